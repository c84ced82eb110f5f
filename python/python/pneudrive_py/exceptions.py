"""What can go wrong, by name. All are :class:`PneuDriveError`; each is also the built-in exception one would expect."""


class PneuDriveError(Exception):
    """Anything that PneuDrive reports."""


class PortError(PneuDriveError, OSError):
    """The serial port cannot be opened, is used by another process, or is gone."""


class CommandError(PneuDriveError, ValueError):
    """A command that cannot be sent: NaN, outside the sensor's range, wrong shape, no such board. Nothing was sent."""


class BoardError(PneuDriveError):
    """An exchange with one board failed. The bus can be used on."""

    def __init__(self, message: str, board: int = -1):
        super().__init__(message)
        #: Number of the board that was asked.
        self.board = board


class NoAnswerError(BoardError, TimeoutError):
    """A board did not answer in time."""


class GarbledAnswerError(BoardError):
    """Something came that is not the answer of the board that was asked."""


class StaleDataError(BoardError):
    """The last exchange with this board failed (or there was none), so there is no current pressure to give."""


class DataError(PneuDriveError, ValueError):
    """A recording, rig, parameter file or argument that cannot be used; the message names file, row and column or the argument."""


class FileError(PneuDriveError, OSError):
    """A file that cannot be read or written."""


class FitError(PneuDriveError, RuntimeError):
    """A model that cannot be fitted to a channel."""


class VentWarning(RuntimeWarning):
    """A board did not confirm the final 0 kPa: it may keep its pressure until its own command timeout."""
