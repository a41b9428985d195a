"""Words of the page of the comparison that do not depend on what was measured."""

HEAD = """
# Planning methods compared

The paper's Table 1 tells advantages and disadvantages of planning methods in words. Here they are
measured: the same problems, vehicle, limits, information and machine, and one judge. `make table1`
repeats all of it in less than ten minutes and writes this page, its pictures and the measurements beside
them (`docs/table1/*.csv`); a run that is interrupted goes on where it was.
"""

CONDITIONS = """
## What is compared

**Methods.** The elastic band as printed (eqs 8-10, forces at the undeformed nodes, k_e/k_s = 0.03),
relaxed, and smoothed by a quadratic program, a node each meter; motion primitives (a state lattice
with 0.15 s between stations and 0.25 m between offsets, searched completely); RRT and RRT* of OMPL over
Dubins curves (up to 40 000 samples); a linear time-varying MPC (PIQP) and a nonlinear one (CasADi,
FATROP or IPOPT) with 40 intervals; and FISS, by its own package, where it is installed. do-mpc is not
among them; its solver is the same CasADi with IPOPT.

**Problems.** One stationary car, a slalom of three, one car in a bend of 200 to 400 m, moving others (a
slow leader, and another one that is met later, half of them oncoming), a gap between two cars with 5 to
20 cm to spare on each side beyond the clearance, and a blocked road where the right answer is that there
is no way: a wall of cars, a car too near to swerve, or a car that stands where an oncoming one is met.
Twenty seeds each: speed 14 to 22 m/s, places and speeds are drawn. Every solvable problem comes with a
sequence of quintic shifts that proves it with 50 to 85 % of the lateral acceleration allowed; the tests
put these proofs before the judge. No method was tuned on these seeds.

**Limits and information.** 0.3 m to all others, the body between the edges, at most 4 m/s² of lateral
acceleration, the wanted speed within 10 %. All others keep lane and speed; every method is given their
boxes at any time, and none is told on which side to pass.

**The judge** knows the samples of a plan alone. It lays a cubic spline through them, takes the distance
of the boxes every 5 ms, the corners against the edges, and curvature over a meter of way, so that the
jumps of Dubins curves are no fault. It forgives, of everybody alike, 5 cm, 5 % of the lateral
acceleration, and at start and end 10 cm and 1.7° to the route. Then the plan is *driven*: the same
preview steering and speed control follow it on the single-track plant with saturating tires, from a
start on the route. Jerk is the change of lateral acceleration within 0.1 s.

**Time** is processor time in a process of its own, on one core, one thread, garbage collection off: the
*first* plan for a problem, with all that a method builds for a new speed or road, and the median of up
to three plans after it, for which libraries and programs are at hand. A plan that raises or takes
longer than 10 s is an entry, not an end.
"""

DIFFERS = """
## What differs between the methods

- RRT, RRT*, the lattice and the bands pass each station of the route at the wanted speed; the MPCs and
  FISS may change speed a little. For RRT this makes moving others a matter of place alone.
- RRT and RRT* hold what the tree finds, shortened by direct motions; RRT* looks for neighbors in 8
  times the radius of OMPL's default, without which it does not rewire in a narrow road, and stops at its
  first solution.
- RRT and the lattice look up a table of free poses that is a few centimeters on the safe side; gaps with
  less to spare are closed to them.
- The MPCs keep an elastic limit to others and judge their own result before they claim it. The nonlinear
  one sees each other as a rounded box, |x/a|^8 + |y/b|^8 = 1, which is 3 % wider than the body, and
  begins where the linear one ends, which chooses the sides; that time is counted.
- FISS plans 1 to 3 s ahead and knows no goal: its plan is put together from one every 0.3 s, and its
  time is that of all of them; it may be back on the route up to 3 s late. Its safety rules beyond a
  clearance are off, as no other method has them.
- The lattice and RRT were tuned on two problems alone, one car that stands 50 m ahead and a slalom of
  three; the bands and the MPCs were developed with the same two in sight.
- FATROP and PIQP have limits of iterations but none of time; here the process ends them.
- The band as printed has no limits to keep and no way to say no.
- The problems are planar, with perfect predictions; what noise or wrong predictions do to a method is
  not measured here.
"""
