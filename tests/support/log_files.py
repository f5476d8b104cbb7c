"""Logs in every format that dehyst reads, each written by the format's own package."""

import gzip
import io
import tempfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np

COLUMNS = ("time_s", "pressure_bar", "angle_deg")
NEEDS = {
    ".xlsx": "python_calamine",
    ".tdms": "nptdms",
    ".parquet": "polars",
    ".feather": "polars",
    ".mcap": "rosbags",
    ".mf4": "asammdf",
}


def text_of(columns, delimiter=",", decimal="."):
    """The columns as text, with all digits."""
    rows = zip(*(np.asarray(values).tolist() for values in columns.values()), strict=True)
    cells = (
        [cell if isinstance(cell, str) else repr(cell).replace(".", decimal) for cell in row]
        for row in rows
    )
    return "".join(delimiter.join(line) + "\n" for line in (columns, *cells))


def _gzip(columns):
    return gzip.compress(text_of(columns).encode(), mtime=0)


def _two_members(columns):
    data = text_of(columns).encode()
    return (
        gzip.compress(data[: len(data) // 2]) + gzip.compress(data[len(data) // 2 :]) + b"\0" * 512
    )


def _saved(save):
    """Bytes of what a function writes into a stream."""

    def written(columns):
        stream = io.BytesIO()
        save(stream, {name: np.asarray(values) for name, values in columns.items()})
        return stream.getvalue()

    return written


def _matrix(columns):
    return np.column_stack(list(columns.values()))


def _records(columns):
    table = np.zeros(len(columns["time_s"]), dtype=[(name, "f8") for name in columns])
    for name, values in columns.items():
        table[name] = values
    return table


def _step(columns):
    kept = {name: values for name, values in columns.items() if name != "time_s"}
    return {**kept, "Ts": columns["time_s"][1] - columns["time_s"][0]}


def _mat(stream, columns, **settings):
    from scipy.io import savemat

    savemat(stream, columns, **settings)


def _hdf5(stream, columns):
    import h5py

    with h5py.File(stream, "w") as out:
        for name, values in columns.items():
            out.create_dataset(name, data=values, compression="gzip")


def _netcdf(stream, columns):
    from scipy.io import netcdf_file

    path = Path(tempfile.mkdtemp()) / "log.nc"
    with netcdf_file(path, "w") as out:
        out.createDimension("time_s", len(columns["time_s"]))
        for name, values in columns.items():
            out.createVariable(name, "d", ("time_s",))[:] = values
    stream.write(path.read_bytes())


def _polars(columns):
    import polars

    return polars.DataFrame(columns)


def _mdf(stream, columns):
    import asammdf

    with asammdf.MDF(version="4.10") as out:
        out.append(
            [asammdf.Signal(columns[name], columns["time_s"], name=name) for name in COLUMNS[1:]]
        )
        out.save(stream)


def _xlsx(stream, columns):
    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["calibrated in May"])
    sheet = book.create_sheet("log")
    for row in (columns, *zip(*(values.tolist() for values in columns.values()), strict=True)):
        sheet.append(list(row))
    book.save(stream)


def _tdms(stream, columns):
    import nptdms

    with nptdms.TdmsWriter(stream) as out:
        out.write_segment(
            [nptdms.ChannelObject("rig", name, values) for name, values in columns.items()]
        )


STRUCT = {"s": {"time": np.arange(5.0), "data": np.arange(5.0)}, "run": ["a", "bc"]}
WRITERS = {
    "plain.csv": lambda columns: text_of(columns).encode(),
    "german.csv": lambda columns: text_of(columns, ";", ",").encode(),
    "crlf.txt": lambda columns: text_of(columns).replace("\n", "\r\n").encode("utf-8-sig"),
    "packed.csv.gz": _gzip,
    "two_members.csv.gz": _two_members,
    "vectors.npz": _saved(lambda stream, columns: np.savez(stream, **columns)),
    "packed.npz": _saved(lambda stream, columns: np.savez_compressed(stream, **columns)),
    "single.npz": _saved(
        lambda s, columns: np.savez(s, **{k: v.astype(np.float32) for k, v in columns.items()})
    ),
    "matrix.npz": _saved(lambda stream, columns: np.savez(stream, data=_matrix(columns))),
    "fortran.npz": _saved(
        lambda stream, columns: np.savez_compressed(
            stream, data=np.asfortranarray(_matrix(columns))
        )
    ),
    "wide.npz": _saved(lambda stream, columns: np.savez(stream, data=_matrix(columns).T)),
    "step.npz": _saved(lambda stream, columns: np.savez(stream, **_step(columns))),
    "matrix.npy": _saved(lambda stream, columns: np.save(stream, _matrix(columns))),
    "records.npy": _saved(lambda stream, columns: np.save(stream, _records(columns))),
    "table.parquet": _saved(
        lambda stream, columns: _polars(columns).write_parquet(stream, row_group_size=999)
    ),
    "table.feather": _saved(lambda stream, columns: _polars(columns).write_ipc(stream)),
    "bag.mcap": None,
    "utf16.txt": lambda columns: text_of(columns, ";", ",").encode("utf-16"),
    "plain.mat": _saved(lambda stream, columns: _mat(stream, {**columns, **STRUCT})),
    "packed.mat": _saved(lambda stream, columns: _mat(stream, columns, do_compression=True)),
    "column.mat": _saved(lambda stream, columns: _mat(stream, columns, oned_as="column")),
    "old.mat": _saved(lambda stream, columns: _mat(stream, columns, format="4")),
    "matrix.mat": _saved(lambda stream, columns: _mat(stream, {"data": _matrix(columns)})),
    "wide.mat": _saved(lambda stream, columns: _mat(stream, {"data": _matrix(columns).T})),
    "step.mat": _saved(lambda stream, columns: _mat(stream, _step(columns))),
    "plain.h5": _saved(_hdf5),
    "classic.nc": _saved(_netcdf),
    "log.mf4": _saved(_mdf),
    "book.xlsx": _saved(_xlsx),
    "log.tdms": _saved(_tdms),
}
FORMS = [form for form in WRITERS if find_spec(NEEDS.get(f".{form.rpartition('.')[2]}", "numpy"))]
# Those that are read in parts where they are long; of .mat files those of version 7.3 are HDF5.
IN_PARTS = [
    form for form in FORMS if not form.endswith((".mat", ".nc", ".xlsx", ".tdms", "utf16.txt"))
]


def save(folder, form, columns):
    """Write the columns under a name that tells the form; return the path, and the names of input and output in it."""
    path = folder / form
    if form == "bag.mcap":
        from dehyst.io import write_mcap

        write_mcap(path, {"j": (columns["time_s"], {name: columns[name] for name in COLUMNS[1:]})})
        return path, "/j.pressure_bar", "/j.angle_deg"
    path.write_bytes(WRITERS[form](columns))
    stem = {"matrix.npy": "column_"}.get(
        form, "data_" if form.startswith(("matrix", "fortran", "wide")) else ""
    )
    return (path, f"{stem}2", f"{stem}3") if stem else (path, "pressure", "angle")
