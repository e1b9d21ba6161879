# Bundles the 3-D view of reports into one script, BUILD/replay.js:
#
#   cmake -D NPM=<npm> -D SOURCE=<this folder> -D BUILD=<folder> -P build.cmake
#
# npm fetches three.js and esbuild in the versions of package-lock.json. Without a network the build
# goes on without the script, reports say so, and the next build tries again.
file(MAKE_DIRECTORY ${BUILD})
file(REMOVE ${BUILD}/replay.js)
file(COPY ${SOURCE}/package.json ${SOURCE}/package-lock.json ${SOURCE}/src DESTINATION ${BUILD})

function(run_npm)
  execute_process(COMMAND ${NPM} ${ARGN} WORKING_DIRECTORY ${BUILD} RESULT_VARIABLE result
                  OUTPUT_VARIABLE output ERROR_VARIABLE output TIMEOUT 180)
  set(failed FALSE PARENT_SCOPE)
  if(NOT result STREQUAL "0")
    list(JOIN ARGN " " words)
    message("the 3-D view of reports was not built (npm ${words}: ${result}):\n${output}")
    set(failed TRUE PARENT_SCOPE)
  endif()
endfunction()

file(SHA256 ${SOURCE}/package-lock.json wanted)
if(EXISTS ${BUILD}/node_modules/.wanted)
  file(READ ${BUILD}/node_modules/.wanted present)
endif()
if(NOT "${present}" STREQUAL "${wanted}")
  run_npm(ci --ignore-scripts --no-audit --no-fund --fetch-retries=1 --fetch-timeout=30000)
  if(failed)
    return()
  endif()
  file(WRITE ${BUILD}/node_modules/.wanted ${wanted})
endif()
run_npm(run build -- --outfile=bundle.js)
if(failed)
  return()
endif()
file(READ ${BUILD}/node_modules/three/LICENSE licence)
file(READ ${BUILD}/bundle.js bundle)
file(WRITE ${BUILD}/replay.js.new "/* This script contains three.js:\n\n${licence}*/\n${bundle}")
file(RENAME ${BUILD}/replay.js.new ${BUILD}/replay.js)
