"""What is installed works: program, library with find_package(hvi), man page, completions, and the Debian package.

usage: install.py CMAKE SOURCE_FOLDER BUILD_FOLDER"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

cmake, source, build = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
FILES = ("bin/hvi-run", "lib/hvi/libhvi_gmsh.so", "lib/hvi/libhvi_mumps.so", "lib/hvi/libhvi_draw.so", "lib/cmake/hvi/hviConfig.cmake", "include/hvi/solver/plan/plan.hpp", "share/hvi/stdlib/contact.hvi",
         "share/man/man1/hvi-run.1.gz", "share/bash-completion/completions/hvi-run", "share/mime/packages/hvi.xml")


def call(*words, **more):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, **more)
    assert done.returncode == 0, f"{words}: exit code {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout


def works(prefix, folder):
    """The program, with the module that makes meshes beside it."""
    for name in FILES:
        assert (prefix / name).is_file(), f"{name} is not installed"
    for script, words in (("slab.hvi", ("-D", "n=4", "-D", "N=4")), ("bracket.hvi", ("--allow-geo",))):
        call(prefix / "bin/hvi-run", source / "examples" / script, *words, "-o", folder / script, cwd=folder)


def main():
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        prefix = folder / "prefix"
        call(cmake, "--install", build, "--prefix", prefix)
        works(prefix, folder)
        shutil.copytree(source / "examples/cpp", folder / "cpp")
        call(cmake, "-S", folder / "cpp", "-B", folder / "own", f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_BUILD_TYPE=Release")
        call(cmake, "--build", folder / "own")
        assert re.search(r"reaction = 3\.680214391.*certified true", call(folder / "own/slab_cpp"), re.S)
        if shutil.which("dpkg-shlibdeps"):
            call(pathlib.Path(cmake).with_name("cpack"), "--config", build / "CPackConfig.cmake", "-G", "DEB", "-B", folder / "deb",
                 "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=gzip")  # faster than xz; nobody keeps it
            packages = {package.name.split("_")[0]: package for package in (folder / "deb").glob("*.deb")}
            assert {"hvi-run", "libhvi-dev"} <= set(packages), packages
            needed = call("dpkg-deb", "-f", packages["hvi-run"], "Depends")
            assert all(name in needed for name in ("libc6", "libopenblas", "libcholmod", "libfmt", "libgmsh")), needed
            for package in packages.values():
                call("dpkg-deb", "-x", package, folder / "root")
            works(folder / "root/usr", folder)
            if "python3-hvi" in packages:
                assert re.search(r"python3 \(>= 3\.\d+\), python3 \(<< 3\.\d+\)", call("dpkg-deb", "-f", packages["python3-hvi"], "Depends"))
                code = f"import hvi; print(hvi.load({str(source / 'examples/bracket.hvi')!r}, allow_geo=True).run().certified, hvi.__file__)"
                said = call("/usr/bin/python3", "-c", code, env={"PYTHONPATH": str(folder / "root/usr/lib/python3/dist-packages")})
                assert said.startswith("True") and str(folder) in said, said
            print(f"{', '.join(p.name for p in packages.values())}; hvi-run needs {needed.strip()}")
    print("installed, found, built against, run")


main()
