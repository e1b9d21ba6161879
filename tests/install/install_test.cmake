# Installs the library into a fresh folder, builds the project beside this file against it, and lets
# its program find an object:  cmake -D BUILD=... -D WORK=... -D LAUNCHER=... -P install_test.cmake
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE result OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGV}\n${out}")
  endif()
  set(out "${out}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE "${WORK}")
foreach(component models recognition)
  run(${CMAKE_COMMAND} --install "${BUILD}" --prefix "${WORK}/prefix" --component ${component})
endforeach()
run(${CMAKE_COMMAND} -S "${CMAKE_CURRENT_LIST_DIR}" -B "${WORK}/build" -G Ninja
    -D CMAKE_BUILD_TYPE=Release -D "CMAKE_PREFIX_PATH=${WORK}/prefix"
    -D "CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}")
run(${CMAKE_COMMAND} --build "${WORK}/build")

set(model "${WORK}/prefix/share/binpick/models/objects/rusk/rusk.obj")
run("${WORK}/build/make_scene" "${model}" "${WORK}/scene.ply")
run("${WORK}/build/recognize_cloud" "${WORK}/scene.ply" "${model}")
# It lies at 50 20 800 mm.
if(NOT out MATCHES "^[^\n]*rusk.obj at (4[789]|5[0123]) (1[789]|2[0123]) (79[789]|80[0123]) mm[^\n]*\n$")
  message(FATAL_ERROR "Not what was put there:\n${out}")
endif()

# A component that is not installed is reported by name.
file(WRITE "${WORK}/other/CMakeLists.txt" "cmake_minimum_required(VERSION 3.25)
project(other LANGUAGES CXX)
find_package(binpick REQUIRED COMPONENTS control)")
execute_process(COMMAND ${CMAKE_COMMAND} -S "${WORK}/other" -B "${WORK}/other/build" -G Ninja
                        -D "CMAKE_PREFIX_PATH=${WORK}/prefix"
                RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE error)
if(result EQUAL 0 OR NOT error MATCHES "control")
  message(FATAL_ERROR "A missing component must be reported:\n${error}")
endif()
file(REMOVE_RECURSE "${WORK}")
