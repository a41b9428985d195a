"""Fit of a `Path` to waypoints: smoothing cubics within a tolerance and a curvature limit."""

import math

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import check_bool, check_points, check_real
from cca_core.errors import InputError
from cca_core.path.path import Path
from cca_core.path.route_fit import RouteFit


def fit_path(
    xy: ArrayLike,
    *,
    tolerance: float | None = None,
    points_per_segment: int = 4,
    segmentation: str = "equal",
    curvature_limit: float | None = None,
    max_deviation: float | None = None,
    closed: bool = False,
) -> Path:
    """Fit a smooth path through waypoints.

    Parameters
    ----------
    xy : array_like, shape (n, 2)
        Waypoints [m], in driving order, no two neighbors equal.
    tolerance : float, optional
        Largest distance between a waypoint and the path [m]. The path is as smooth as this allows; 0
        interpolates. By default it is chosen from the noise of the waypoints, and the path has no curve that
        an ordinary car cannot drive.
    points_per_segment : int
        Waypoints in each segment of the equal segmentation [-]; halved until the tolerance is feasible.
    segmentation : {"equal", "adaptive"}
        Segments of equal waypoint count, or as long as the tolerance allows.
    curvature_limit : float, optional
        Largest curvature of the path [1/m], for example of the turning circle. If limit and tolerance
        contradict each other, the limit wins, and the path passes as near as it can.
    max_deviation : float, optional
        Largest distance of a waypoint that the curvature limit excludes [m]. The default is the largest of
        10 m, three tolerances, and ``tolerance + 0.6 / curvature_limit`` (at most 30 m).
    closed : bool
        Whether the road returns from the last waypoint to the first. The path then ends at its start, with
        the same heading and curvature.

    Returns
    -------
    path : Path
        Segments joined with continuous position, heading and curvature, over true arc length. Its
        `fit_report` names the tolerance, and every waypoint that is farther away than that.

    Raises
    ------
    InputError
        If there are fewer than two waypoints, neighbors coincide, or an argument is out of range.
    InfeasibleError
        If no path keeps the tolerance at every waypoint, or the curvature limit within `max_deviation` of
        every waypoint. `result` is the nearest path that was found, or None.

    See Also
    --------
    clean_route : clean a recorded route into parts that can be fitted.

    Notes
    -----
    Eqs (1) and (2) of the paper with continuous second derivatives are a cubic B-spline with one knot per
    segment border. The fit minimizes ``integral |X - P|^2 + l^8 |X'''' - Q|^2 ds`` over these splines. The
    smoothing length l is the largest for which no waypoint is farther away than `tolerance`. Q is the fourth
    derivative of a clothoid: straight lines, circles and clothoids, of which roads consist, are equally
    smooth. The parameter is the chord length first, and then the arc length of the last fit. The result is
    interpolated again over its arc length, and the length of dX/ds is 1 within 1e-3. Segments that turn by
    more than 0.1 rad are divided further. The cost is linear in n.

    Between waypoints the path deviates from their chords by at most `tolerance` plus 0.3 times the longest of
    three neighboring chords (three times `tolerance` in gaps). A curve that would deviate more gets points on
    its chords.

    The tolerance is rounded down to one of nine values in each decade: 1, 1.5, 2, 2.5, 3, 4, 5, 6 and 8.
    If the path has a radius below 200 m or fails, lower values are tried too. A larger tolerance therefore
    never fails where a smaller one works, and never gives a sharper curve (by more than 2 %).

    The chosen tolerance is the largest of n normal errors, ``sqrt(2 ln n) + 0.3`` standard deviations of the
    noise and at least 3.3 of them; it is at least 0.3 m and at most 10 m. The noise is the median, over all
    windows of six (or eight) waypoints, of the scatter about a cubic (a quintic). Where the waypoints are
    denser than seven standard deviations, every second one is taken, and so on while the estimate grows by
    less than 75 %.
    One waypoint in fifty, and one more, may be an outlier: it is ignored if its neighbors are near the
    path. One farther away than the default of `max_deviation` is a corner of the road and not ignored,
    unless the route turns by more than 100 degrees there. If a curve has a radius below 6 m, 1.5 and 2
    tolerances are tried, and then the limit of 1/6 m is imposed.

    With a curvature limit the tolerance holds for the waypoints that a curve within the limit can reach.
    Curves are cut where that suffices and steering can follow. Others, such as a narrow U-turn or a zig-zag,
    are replaced by arcs and lines of 1.25 times the least radius: of all chains between poses along the route
    the one that deviates and adds least.

    Examples
    --------
    >>> path = fit_path([[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [30.0, 0.0]])
    >>> path
    Path(1 segments, 30.0 m, straight, max deviation 0.00 m at s=...)
    """
    points, closed = check_points("xy", xy, 2), check_bool("closed", closed)
    per_segment = check_real("points_per_segment", points_per_segment, ge=1)
    if per_segment != int(per_segment):
        raise InputError(f"points_per_segment must be a whole number, was {per_segment:g}")
    if segmentation not in ("equal", "adaptive"):
        raise InputError(f"segmentation must be 'equal' or 'adaptive', was {segmentation!r}")
    if tolerance is not None:
        tolerance = check_real("tolerance", tolerance, ge=0.0)
    limit = math.inf
    if curvature_limit is not None:
        limit = check_real("curvature_limit", curvature_limit, gt=0.0)
    if max_deviation is not None:
        max_deviation = check_real("max_deviation", max_deviation, ge=0.0)
    if closed:
        if not np.array_equal(points[0], points[-1]):
            points = np.vstack((points, points[:1]))
        if len(points) < 4:
            raise InputError(
                f"xy must have at least 3 different points for a closed path, had {len(points) - 1}"
            )
    chords = np.hypot(*np.diff(points, axis=0).T)
    if (chords <= 0.0).any():
        i = int(np.argmin(chords))
        raise InputError(f"xy must not repeat a point, row {i} equals the next; clean_route drops it")
    fit = RouteFit(points, closed, int(per_segment) if segmentation == "equal" else None, max_deviation)
    if tolerance is None:
        return fit.from_noise(limit)
    return fit.within(tolerance) if limit == math.inf else fit.within_limit(tolerance, limit)
