# What the compiled parts of dehyst share, those of the kernel and those of the robot: Python, nanobind, flags.
set(CMAKE_C_STANDARD 11)
set(CMAKE_C_STANDARD_REQUIRED ON)
set(CMAKE_C_EXTENSIONS OFF)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

find_package(Python 3.11 REQUIRED COMPONENTS Interpreter Development.Module OPTIONAL_COMPONENTS Development.SABIModule)
find_package(nanobind CONFIG REQUIRED)

if(MSVC AND NOT (CMAKE_C_COMPILER_ID MATCHES Clang AND CMAKE_CXX_COMPILER_ID MATCHES Clang))
  message(FATAL_ERROR "dehyst cannot be compiled by Microsoft's cl, which lacks the vector types of engine/ and would give "
    "other last digits. Use clang-cl: install \"C++ Clang tools for Windows\" in the Visual Studio Installer, then "
    "set CMAKE_GENERATOR_TOOLSET=ClangCL and install again.")
endif()
# -ffp-contract=off: the same bits on machines with and without fused multiply-add.
if(MSVC)
  set(flags /clang:-O3 /clang:-ffp-contract=off /W3)
else()
  set(flags -O3 -ffp-contract=off -Wall -Wextra -Wconversion -Wpedantic)
endif()
if(DEHYST_WERROR)
  list(APPEND flags -Werror)
endif()
if(NOT MSVC)
  add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-includestdio.h>) # nanobind's stderr, with libc++ in the limited API
endif()

# A part of the extension, of sources, that sees the folders named after them.
function(dehyst_part name sources)
  add_library(${name} OBJECT ${sources})
  target_include_directories(${name} PUBLIC ${ARGN})
  set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON C_VISIBILITY_PRESET hidden)
  target_compile_options(${name} PRIVATE ${flags})
  set(parts ${parts} ${name} PARENT_SCOPE)
endfunction()
