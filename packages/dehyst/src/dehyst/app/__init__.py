"""The commands of the command line: each module runs one command and prints its result."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.app._command import Command as Command
    from dehyst.app._design import Designed as Designed
    from dehyst.app._ending import Status as Status
    from dehyst.app._ending import concluding as concluding
    from dehyst.app._ending import end as end
    from dehyst.app._ending import heed as heed
    from dehyst.app._ending import let_go as let_go
    from dehyst.app._targets import PAGE as PAGE
    from dehyst.app._targets import refuse_clashes as refuse_clashes
    from dehyst.app._targets import refuse_existing as refuse_existing
    from dehyst.app._targets import refuse_other_model as refuse_other_model
    from dehyst.app._targets import refuse_unwritable as refuse_unwritable
    from dehyst.app._targets import save_model_file as save_model_file
    from dehyst.app._terminal import ask_progress as ask_progress
    from dehyst.app._terminal import print_end as print_end
    from dehyst.app._terminal import print_findings as print_findings
    from dehyst.app._terminal import print_json as print_json
    from dehyst.app._terminal import progress_bar as progress_bar
    from dehyst.app._terminal import table as table
    from dehyst.app._terminal import tell as tell
    from dehyst.app._terminal import tell_progress as tell_progress
    from dehyst.app.requests import DesignRequest as DesignRequest
    from dehyst.app.requests import argument as argument
    from dehyst.app.requests import option as option

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.app",
    {
        "_command": "Command",
        "_design": "Designed",
        "_ending": "Status concluding end heed let_go",
        "_targets": "PAGE refuse_clashes refuse_existing refuse_other_model refuse_unwritable save_model_file",
        "_terminal": "ask_progress print_end print_findings print_json progress_bar table tell tell_progress",
        "requests": "DesignRequest argument option",
    },
)
