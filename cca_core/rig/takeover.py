"""Edges of enable and clear that the vehicle computer sends to take over from the kit."""

from cca_core.rig.kit import KitState


class Takeover:
    """Enable and clear for the next command, from what the kit reports.

    Parameters
    ----------
    clears : bool
        Whether to ask the kit to clear a safe stop. On a vehicle a person decides that.

    Notes
    -----
    The kit wants edges: three cycles without `enable` and then with it, or without `clear` and then with it.
    While nothing changes the edge is repeated every ten cycles. An override is never cleared here: the driver
    has taken over.
    """

    def __init__(self, *, clears: bool = True) -> None:
        self._clears = clears
        self._state: KitState | None = None
        self._cycles = 0

    def next(self, state: KitState, *, is_ready: bool) -> tuple[bool, bool]:
        """Return enable and clear.

        Parameters
        ----------
        state : KitState
            State of the kit.
        is_ready : bool
            Whether the vehicle computer has a command and a safe stop for the present motion.

        Returns
        -------
        enable, clear : bool
            Content of the next command.
        """
        self._cycles = self._cycles + 1 if state is self._state and is_ready else 0
        self._state = state
        is_asking = self._cycles % 10 >= 3
        if state is KitState.DISABLED:
            return is_asking, False
        if state is KitState.OVERRIDE:
            return False, False
        return True, state is KitState.SAFE_STOP and self._clears and is_asking
