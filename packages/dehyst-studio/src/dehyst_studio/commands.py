"""Commands of the studio: what `dehyst` gains by entry points of the group ``dehyst.commands``."""

from dehyst.app import Command
from dehyst_studio.requests import PageRequest, StudioRequest, WatchRequest

PAGE = Command("dehyst_studio.page:run_page", PageRequest)
STUDIO = Command("dehyst_studio.studio:run_studio", StudioRequest)
WATCH = Command("dehyst_studio.watch_command:run_watch", WatchRequest)
