"""What a target is written with."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.export._budget import CLOCKS as CLOCKS
    from dehyst.export._budget import budget as budget
    from dehyst.export._exchange import alone as alone
    from dehyst.export._exchange import repair as repair
    from dehyst.export._folder import MANIFEST as MANIFEST
    from dehyst.export._folder import VERIFIED as VERIFIED
    from dehyst.export._folder import exported_files as exported_files
    from dehyst.export._folder import refuse_folder as refuse_folder
    from dehyst.export._folders import TEMPLATES as TEMPLATES
    from dehyst.export._folders import add_templates as add_templates
    from dehyst.export._kinds import controller_kind as controller_kind
    from dehyst.export._names import check_name as check_name
    from dehyst.export._names import identifier as identifier
    from dehyst.export._names import why_prefixed as why_prefixed
    from dehyst.export._numbers import direct_in as direct_in
    from dehyst.export._numbers import direct_numbers as direct_numbers
    from dehyst.export._numbers import model_numbers as model_numbers
    from dehyst.export._rendering import comment as comment
    from dehyst.export._rendering import plain_template as plain_template
    from dehyst.export._rendering import render as render
    from dehyst.export._signal import ALL as ALL
    from dehyst.export._signal import read_excerpt as read_excerpt
    from dehyst.export._signal import same_bits as same_bits
    from dehyst.export._signal import to_hex as to_hex
    from dehyst.export._signal import use_findings as use_findings
    from dehyst.export._signal import use_of as use_of
    from dehyst.export._subject import RAMP as RAMP
    from dehyst.export._subject import REALS as REALS
    from dehyst.export._subject import TUNING as TUNING
    from dehyst.export._subject import WHATS as WHATS
    from dehyst.export._subject import check_choice as check_choice
    from dehyst.export._targets import BLOCKS as BLOCKS
    from dehyst.export._targets import Target as Target
    from dehyst.export._targets import Writer as Writer
    from dehyst.export._targets import target as target
    from dehyst.export._targets import targets as targets
    from dehyst.export._verification import Verification as Verification
    from dehyst.export._verification import verify_folder as verify_folder
    from dehyst.export.c import template_values as template_values
    from dehyst.export.c import unit_files as unit_files
    from dehyst.export.c import with_warning as with_warning
    from dehyst.export.compilers import PATIENCE as PATIENCE
    from dehyst.export.compilers import check_folder as check_folder
    from dehyst.export.compilers import plain_environment as plain_environment
    from dehyst.export.compilers import run_program as run_program
    from dehyst.export.compilers import version_of as version_of
    from dehyst.export.core_files import CONFIG as CONFIG
    from dehyst.export.precision import FLOAT_LIMIT as FLOAT_LIMIT
    from dehyst.export.precision import INPUT_LIMIT as INPUT_LIMIT
    from dehyst.export.precision import check_float as check_float
    from dehyst.export.precision import check_values as check_values
    from dehyst.export.precision import in_real as in_real
    from dehyst.export.precision import pattern as pattern
    from dehyst.export.precision import rounded as rounded

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.export.kit",
    {
        "_budget": "CLOCKS budget",
        "_exchange": "alone repair",
        "_folder": "MANIFEST VERIFIED exported_files refuse_folder",
        "_kinds": "controller_kind",
        "_names": "check_name identifier why_prefixed",
        "_numbers": "direct_in direct_numbers model_numbers",
        "_folders": "TEMPLATES add_templates",
        "_rendering": "comment plain_template render",
        "_signal": "ALL read_excerpt same_bits to_hex use_findings use_of",
        "_subject": "RAMP REALS TUNING WHATS check_choice",
        "_targets": "BLOCKS Target Writer target targets",
        "_verification": "Verification verify_folder",
        "c": "template_values unit_files with_warning",
        "compilers": "PATIENCE check_folder plain_environment run_program version_of",
        "core_files": "CONFIG",
        "precision": "FLOAT_LIMIT INPUT_LIMIT check_float check_values in_real pattern rounded",
    },
)
