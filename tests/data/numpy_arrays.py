"""Makes numpy.npz: arrays as NumPy writes them, for tests/data.rs. Needs numpy; the file comes out the same each time."""
import io, pathlib, zipfile
import numpy as np
from numpy.lib import format as npy

arrays = {
    "plain": np.arange(6.0).reshape(2, 3) / 3,
    "one": np.array([0.5, -0.0, 5e-324]),
    "scalar": np.array(7.0),
    "empty": np.zeros((0, 3)),
    "wide": np.arange(24.0).reshape(1, 2, 3, 4),
    "second": np.array([1.0, 2.0]),  # in version 2.0 of the format
    "third": np.array([3.0]),  # in version 3.0
    "big": np.array([0.5, 1e300], dtype=">f8"),
    # What `read` does not take:
    "turned": np.asfortranarray(np.arange(4.0).reshape(2, 2)),
    "whole": np.arange(3),
    "single": np.arange(3, dtype="<f4"),
    "fields": np.zeros(2, dtype=[("<f8", "<f8"), ("shape", "<i4")]),
}
versions = {"second": (2, 0), "third": (3, 0)}

with zipfile.ZipFile(pathlib.Path(__file__).parent / "numpy.npz", "w") as archive:
    for name, array in arrays.items():
        file = io.BytesIO()
        npy.write_array(file, array, version=versions.get(name, (1, 0)))
        archive.writestr(zipfile.ZipInfo(f"{name}.npy"), file.getvalue())
