# Installs the build into an empty folder, builds outsider.cpp against what lies there, runs it on a scene whose photos it
# holds in memory, and compares what it wrote with what `gpvc texture` wrote, byte for byte.
#   cmake -DBUILD=DIR -DSOURCE=tests/install -DSCRATCH=DIR -DCITY=DIR -DEXPECTED=DIR -DBUILD_TYPE=Release
#         -DGENERATOR=Ninja -DCXX_COMPILER=c++ -DCXX_FLAGS= -P install_test.cmake
file(REMOVE_RECURSE ${SCRATCH})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${SCRATCH}/made --component library)
if(NOT CXX_FLAGS)  # with sanitizers the program takes three seconds to start, and each man page is its help
  run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${SCRATCH}/made --component program)
  foreach(file bin/gpvc share/man/man1/gpvc-texture.1 share/bash-completion/completions/gpvc share/gpvc/workflow/Snakefile)
    if(NOT EXISTS ${SCRATCH}/made/${file})
      message(FATAL_ERROR "${file} is not installed")
    endif()
  endforeach()
endif()
# Nothing may remember where it was installed.
file(RENAME ${SCRATCH}/made ${SCRATCH}/prefix)
file(GLOB_RECURSE exported ${SCRATCH}/prefix/*/gpvcTargets*.cmake)
foreach(file ${exported})
  file(STRINGS ${file} absolute REGEX "[;\"](/usr/|/opt/|${SCRATCH})")
  if(absolute)
    message(FATAL_ERROR "${file} names places of this machine: ${absolute}")
  endif()
endforeach()
if(EXISTS ${SCRATCH}/prefix/bin/gpvc)  # which finds the module of other formats than JPEG and PNG where it lies now
  file(WRITE ${SCRATCH}/ppm/photo.ppm "P3 1 1 255 9 99 199\n")
  file(WRITE ${SCRATCH}/ppm/transforms.json [==[{"w": 1, "h": 1, "fl_x": 1, "fl_y": 1, "cx": 0.5, "cy": 0.5,
    "frames": [{"file_path": "photo.ppm", "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]}]}]==])
  run(${CMAKE_COMMAND} -E env --unset=LD_LIBRARY_PATH ${SCRATCH}/prefix/bin/gpvc inspect ${SCRATCH}/ppm/transforms.json)
endif()
if(EXISTS ${SCRATCH}/prefix/bin/gpvc)  # and that of GeoTIFF
  run(${CMAKE_COMMAND} -E env --unset=LD_LIBRARY_PATH ${SCRATCH}/prefix/bin/gpvc ortho --from ${EXPECTED} --gsd 1 -o ${SCRATCH}/ortho)
endif()
run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${SOURCE} -B ${SCRATCH}/build -DCMAKE_PREFIX_PATH=${SCRATCH}/prefix
    -DCMAKE_BUILD_TYPE=${BUILD_TYPE} -DCMAKE_CXX_COMPILER=${CXX_COMPILER} -DCMAKE_CXX_FLAGS=${CXX_FLAGS})
run(${CMAKE_COMMAND} --build ${SCRATCH}/build)
run(${SCRATCH}/build/outsider ${CITY}/colmap ${CITY}/mesh.ply ${SCRATCH}/textured)
foreach(file labels.npy tags.npy faces.npy model.obj model.mtl model_0.jpg model.glb preview.png)
  run(${CMAKE_COMMAND} -E compare_files ${EXPECTED}/${file} ${SCRATCH}/textured/${file})
endforeach()
file(GLOB written RELATIVE ${SCRATCH}/prefix LIST_DIRECTORIES false ${SCRATCH}/prefix/include/*)
if(written)
  message(FATAL_ERROR "headers outside include/gpvc: ${written}")
endif()
