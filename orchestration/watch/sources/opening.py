"""The source of a name: a file, standard input, or an address."""

from __future__ import annotations

from pathlib import Path

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.watch.sources.lines import LinesSource
from warmlink.orchestration.watch.sources.mapping import read_mapping
from warmlink.orchestration.watch.sources.protocol import FilePlace, Source

STANDARD_INPUT = "-"


def opened(name: str, follow: bool, begin: FilePlace | None = None, mapping: Path | None = None) -> Source:
    """Open a source.

    Parameters
    ----------
    name : path of a log, - for standard input, `mqtt://host/topic` or `opc.tcp://host:port`
    follow : whether to wait for more at the end of a file
    begin : where in a file an earlier run ended
    mapping : file that says which value of a server stands under which header

    Raises
    ------
    InputError
        There is no such source, or it cannot be read.
    """
    scheme, there, _ = name.partition("://")
    if there and scheme not in ("mqtt", "opc.tcp"):
        raise InputError(f"{name}: is no source; give a file, - for standard input, mqtt:// or opc.tcp://")
    if not there:
        if mapping is not None:
            raise InputError(
                f"{argument('mapping', mapping)}: is for servers; {argument('names')} is for files"
            )
        return LinesSource(None if name == STANDARD_INPUT else Path(name), follow, begin)
    columns = {} if mapping is None else read_mapping(mapping)
    if scheme == "mqtt":
        from warmlink.orchestration.watch.sources.mqtt import MqttSource

        return MqttSource(name, columns)
    from warmlink.orchestration.watch.sources.opcua import OpcuaSource

    return OpcuaSource(name, columns)
