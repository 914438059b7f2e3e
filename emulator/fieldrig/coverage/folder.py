"""The folder in which the processes of a run note what they have run; the pytest plugin loads this and no more."""

from typing import Final

FOLDER_VARIABLE: Final = "FIELDRIG_COVERAGE_FOLDER"
"""The environment variable with the folder, for the processes that this one starts."""
DETAIL_VARIABLE: Final = "FIELDRIG_COVERAGE_DETAIL"
"""The environment variable that is there if conditions and the states of enumerations count as well."""
