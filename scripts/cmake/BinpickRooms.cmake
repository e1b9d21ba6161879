# The rooms of the house and the rule between them.
#
# Headers are included by their path from the repository's root ("control/ik.h"). A room sees only
# the rooms it names in DEPENDS: each room exports an include directory that holds nothing but a
# link to itself, so that an include against the rule fails to compile.

set(BINPICK_WARNINGS -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror)

add_library(binpick_build_flags INTERFACE)
target_link_libraries(binpick_build_flags INTERFACE Threads::Threads)
# No contraction to FMA: the same seed gives the same bytes on every path through the code.
target_compile_options(binpick_build_flags INTERFACE ${BINPICK_WARNINGS} -ffp-contract=off)
if(BINPICK_SANITIZE)
  target_compile_options(binpick_build_flags INTERFACE -fsanitize=${BINPICK_SANITIZE}
                                                       -fno-omit-frame-pointer)
  target_link_options(binpick_build_flags INTERFACE -fsanitize=${BINPICK_SANITIZE})
endif()

# binpick_add_room(NAME [DEPENDS room...] [PUBLIC library...] [PRIVATE library...])
# Builds the static library binpick_NAME from every .cpp of the current folder. Its code may go into
# a shared library (a Python module, say); calls inside it are bound like those of a program.
# binpick_install_room (BinpickInstall.cmake) makes it part of the package.
function(binpick_add_room name)
  cmake_parse_arguments(ARG "" "" "DEPENDS;PUBLIC;PRIVATE" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "_main\\.cpp$")
  set(door ${CMAKE_BINARY_DIR}/rooms/${name})
  file(MAKE_DIRECTORY ${door})
  file(CREATE_LINK ${CMAKE_SOURCE_DIR}/${name} ${door}/${name} SYMBOLIC)
  add_library(binpick_${name} STATIC ${sources})
  add_library(binpick::${name} ALIAS binpick_${name})
  set_target_properties(binpick_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_compile_options(binpick_${name} PRIVATE -fno-semantic-interposition)
  target_compile_features(binpick_${name} PUBLIC cxx_std_20)
  target_include_directories(binpick_${name} PUBLIC $<BUILD_INTERFACE:${door}>
                                                    $<INSTALL_INTERFACE:include/binpick>)
  list(TRANSFORM ARG_DEPENDS PREPEND binpick_)
  target_link_libraries(binpick_${name} PUBLIC ${ARG_DEPENDS} ${ARG_PUBLIC} Eigen3::Eigen
                                        PRIVATE ${ARG_PRIVATE}
                                                $<BUILD_INTERFACE:binpick_build_flags>)
endfunction()

# binpick_add_tests(NAME LABEL label ROOMS room... [LIBRARIES library...] [SOURCES file...])
# Builds the test program NAME, by default from every *_test.cpp of the current folder.
function(binpick_add_tests name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT" "ROOMS;LIBRARIES;SOURCES" ${ARGN})
  if(NOT ARG_SOURCES)
    file(GLOB ARG_SOURCES CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*_test.cpp)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  if(NOT ARG_SOURCES)
    return()
  endif()
  add_executable(${name} ${ARG_SOURCES})
  list(TRANSFORM ARG_ROOMS PREPEND binpick_)
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
  target_compile_definitions(${name} PRIVATE BINPICK_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  target_link_libraries(${name} PRIVATE ${ARG_ROOMS} ${ARG_LIBRARIES} GTest::gmock_main
                                        binpick_build_flags)
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60
                       PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT})
endfunction()

# binpick_add_benchmarks(NAME ROOMS room...): from every *_benchmark.cpp of the current folder.
function(binpick_add_benchmarks name)
  cmake_parse_arguments(ARG "" "" "ROOMS;LIBRARIES" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*_benchmark.cpp)
  if(NOT BINPICK_BENCHMARKS OR NOT sources)
    return()
  endif()
  find_package(benchmark REQUIRED)
  add_executable(${name} ${sources})
  list(TRANSFORM ARG_ROOMS PREPEND binpick_)
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
  target_compile_definitions(${name} PRIVATE BINPICK_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  target_link_libraries(${name} PRIVATE ${ARG_ROOMS} ${ARG_LIBRARIES} benchmark::benchmark_main
                                        binpick_build_flags)
endfunction()
