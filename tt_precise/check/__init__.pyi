from .result import Result as Result
from .run import assert_conserves as assert_conserves
from .run import assert_matches_golden as assert_matches_golden
from .run import conservation as conservation
