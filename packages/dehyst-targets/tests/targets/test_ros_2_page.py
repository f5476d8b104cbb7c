"""The page of ROS 2: its files are built by ROS 2's own tools and loaded by pluginlib; the base class is a stand-in."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from dehyst.export import export, subject_of
from export_samples import play_model
from places import ROOT

PAGE = ROOT / "docs" / "how-to" / "use-in-ros-2.md"
BASE = """
#pragma once
namespace filters {
template <typename T> class FilterBase {
public:
    virtual ~FilterBase() = default;
    bool started() { return configure(); }
    virtual bool update(const T &in, T &out) = 0;
protected:
    virtual bool configure() = 0;
};
}
"""
CONFIG = 'set(filters_INCLUDE_DIRS "${CMAKE_CURRENT_LIST_DIR}/../../../include")\n'
LOADER = """
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <filters/filter_base.hpp>
#include <pluginlib/class_loader.hpp>
int main()
{
    pluginlib::ClassLoader<filters::FilterBase<double>> loader("filters", "filters::FilterBase<double>");
    auto filter = loader.createUniqueInstance("elbow_filter/ElbowFilter");
    if (!filter->started()) return 1;
    for (std::uint64_t word; std::scanf("%" SCNx64, &word) == 1;) {
        double in, out;
        std::memcpy(&in, &word, sizeof in);
        const bool good = filter->update(in, out);
        std::memcpy(&word, &out, sizeof out);
        std::printf("%016" PRIx64 " %d\\n", word, !good);
    }
}
"""
ROS = all(map(shutil.which, ("cmake", "g++"))) and Path("/usr/share/pluginlib/cmake").is_dir()


def built(folder, target, *options):
    """Build a folder with CMake as colcon does; Debian's ament needs Debian's Python."""
    given = ("-DPython3_EXECUTABLE=/usr/bin/python3", *options)
    script = f"cmake -S . -B build {' '.join(given)} && cmake --build build --target {target}"
    made = subprocess.run(script, shell=True, cwd=folder, capture_output=True, text=True)
    assert made.returncode == 0, made.stdout + made.stderr


@pytest.mark.slow
@pytest.mark.skipif(not ROS, reason="needs apt-get install cmake g++ pluginlib-dev")
def test_the_files_of_the_page_are_a_plugin_that_answers_to_the_bit(tmp_path):
    names = ["elbow_filter.cpp", "elbow_filter.xml", "package.xml", "CMakeLists.txt"]
    page = PAGE.read_text()
    blocks = re.findall(r"```(?:cpp|xml|cmake)\n(.*?)```", page, re.DOTALL)
    assert [name for name in re.findall(r"`([\w.]+)`", page) if name in names] == names and len(
        blocks
    ) == 4
    stand, place, loader = tmp_path / "filters", tmp_path / "package", tmp_path / "loader"
    texts = dict(zip((place / name for name in names), blocks, strict=True))
    texts |= {
        stand / "include/filters/filter_base.hpp": BASE,
        stand / "share/filters/cmake/filtersConfig.cmake": CONFIG,
    }
    build = blocks[3].split("file(GLOB")[0].replace("project(elbow_filter", "project(loader")
    ends = (
        "add_executable(loader loader.cpp)\nament_target_dependencies(loader filters pluginlib)\n"
    )
    texts |= {
        loader / "loader.cpp": LOADER,
        loader / "CMakeLists.txt": f"{build}set(CMAKE_CXX_STANDARD 17)\n{ends}",
    }
    installed = tmp_path / "installed"
    texts[installed / "share/ament_index/resource_index/packages/filters"] = ""
    for path, text in texts.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    subject = subject_of(play_model(), name="elbow")
    export(subject, "c", place / "elbow")
    built(place, "install", f"-DCMAKE_PREFIX_PATH={stand}", f"-DCMAKE_INSTALL_PREFIX={installed}")
    built(loader, "all", f"-DCMAKE_PREFIX_PATH={stand}")
    samples = int(np.argmin(subject.test.switch))  # up to there it is on
    words = subject.test.inputs[:samples, 0].view(np.uint64)
    env = os.environ | {
        "AMENT_PREFIX_PATH": str(installed),
        "LD_LIBRARY_PATH": str(installed / "lib"),
    }
    told = "\n".join(f"{word:x}" for word in words)
    done = subprocess.run(
        [loader / "build" / "loader"], input=told, capture_output=True, text=True, env=env
    )
    assert done.returncode == 0, done.stderr
    rows = [(int(word, 16), int(bad)) for word, bad in map(str.split, done.stdout.splitlines())]
    expected = subject.test.outputs[:samples, 0].view(np.uint64), subject.test.flags[:samples] & 1
    assert samples > 50 and rows == [(int(y), int(flag)) for y, flag in zip(*expected, strict=True)]
