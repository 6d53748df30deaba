"""Builds the wheel: compiles the module by the project's own CMake, and puts the libraries that it needs beside it.

Nothing is downloaded, and nothing beyond Debian's packages is needed (app/setup/install_packages.sh wheel). PEP 517's hooks are
build_wheel() and build_sdist().
"""

import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

PACKAGE = pathlib.Path(__file__).resolve().parent.parent
ROOT = PACKAGE.parent.parent


def _version():
    return re.search(r"project\(gpvc VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)


def _metadata():
    return (
        f"Metadata-Version: 2.1\nName: gpvc\nVersion: {_version()}\n"
        "Summary: Photo texture for triangle meshes, and which faces photos see\n"
        "Requires-Python: >=3.11\nRequires-Dist: numpy>=1.24\nDescription-Content-Type: text/markdown\n\n"
        + (PACKAGE / "README.md").read_text()
    )


def _tag():
    """Of this Python and this C library, as new as which a system has to be."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    glibc = os.confstr("CS_GNU_LIBC_VERSION").split()[1].replace(".", "_")
    machine = sysconfig.get_platform().split("-", 1)[1].replace("-", "_")
    return f"{python}-{python}-manylinux_{glibc}_{machine}"


def _build(folder):
    build = pathlib.Path(os.environ.get("GPVC_WHEEL_BUILD", ROOT / "build" / "wheel"))
    options = ["-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON", "-DGPVC_PYTHON=ON", "-DGPVC_PYTHON_DIR=.",
               f"-DPython_EXECUTABLE={sys.executable}"]
    subprocess.run(["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", *options], check=True)
    subprocess.run(["cmake", "--build", build, "--target", "gpvc_python"], check=True)
    subprocess.run(["cmake", "--install", build, "--prefix", folder, "--component", "python"], check=True)
    module = next((folder / "gpvc").glob("_gpvc*.so"))
    subprocess.run([ROOT / "app/setup/take_libraries.sh", module, folder / "gpvc.libs", folder / "gpvc.libs" / "licences"], check=True)
    subprocess.run(["patchelf", "--force-rpath", "--set-rpath", "$ORIGIN/../gpvc.libs", module], check=True)


def _record(path, data):
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return f"{path},sha256={digest},{len(data)}\n"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    name, info = f"gpvc-{_version()}-{_tag()}.whl", f"gpvc-{_version()}.dist-info"
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        _build(folder)
        files = {path.relative_to(folder).as_posix(): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}
    files[f"{info}/METADATA"] = _metadata().encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: gpvc\nRoot-Is-Purelib: false\nTag: {_tag()}\n".encode()
    record = "".join(_record(path, data) for path, data in files.items()) + f"{info}/RECORD,,\n"
    files[f"{info}/RECORD"] = record.encode()
    with zipfile.ZipFile(os.path.join(wheel_directory, name), "w", zipfile.ZIP_DEFLATED, compresslevel=9) as wheel:
        for path, data in files.items():
            entry = zipfile.ZipInfo(path, date_time=(2020, 1, 1, 0, 0, 0))  # the same bytes from the same files
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o100644 << 16
            wheel.writestr(entry, data, compresslevel=9)
    return name


def build_sdist(sdist_directory, config_settings=None):
    raise RuntimeError("there is no source distribution of the module alone: it is built in gpvc's source tree, with --wheel")
