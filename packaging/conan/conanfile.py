"""Untested. conan create packaging/conan"""
import os

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy


class Sqmap(ConanFile):
    name, version = "sqmap", "0.2.0"
    license = "Apache-2.0"
    description = "Contact between complex shapes at 1 kHz on one core"
    settings = "os", "compiler", "build_type", "arch"
    requires = "eigen/3.4.0", "flatbuffers/24.3.25", "highway/1.2.0", "nlohmann_json/3.11.3"
    tool_requires = "flatbuffers/24.3.25", "cmake/[>=3.25]"

    def export_sources(self):
        root = os.path.join(self.recipe_folder, "..", "..")
        for pattern in ("CMakeLists.txt", "LICENSE", "cmake/*", "include/*", "src/*"):
            copy(self, pattern, src=root, dst=self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        for option in ("TESTS", "APPS", "BENCH"):
            toolchain.cache_variables[f"SQMAP_BUILD_{option}"] = False
        toolchain.cache_variables["SQMAP_BUILD_C"] = True
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", src=self.source_folder, dst=os.path.join(self.package_folder, "licenses"))
        CMake(self).install()

    def package_info(self):
        self.cpp_info.set_property("cmake_find_mode", "none")  # its own sqmapConfig.cmake
        self.cpp_info.builddirs.append(os.path.join("lib", "cmake", "sqmap"))
