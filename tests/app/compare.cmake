gpvc_test(compare_test gpvc_cli)

# `gpvc compare` on app_test's scene, and its page in headless Chromium.
find_program(GPVC_NODE node)
find_program(GPVC_CHROMIUM chromium)
set(compared ${CMAKE_CURRENT_BINARY_DIR}/compared)
add_test(NAME compare.scene
         COMMAND gpvc compare ${app_scene}/colmap ${app_scene}/mesh.ply -o ${compared} --force --quiet --keep-models
                 --modes none,shadow-map:spc,gpvc:uncorrected,gpvc --eps 1e-5,1e-2 --hold-out 5 --oracle-views 2
                 --crops 4 --reduction 1)
add_test(NAME compare.external
         COMMAND gpvc compare ${app_scene}/colmap ${app_scene}/mesh.ply -o ${compared}/external --force --quiet
                 --modes none --external again=${compared}/modes/gpvc/model.obj --hold-out 5 --oracle-views 0
                 --crops 0 --reduction 1)
add_test(NAME compare.summary
         COMMAND gpvc compare --summarize ${compared}/report.json -o ${compared}/summary --force)
set_tests_properties(compare.scene PROPERTIES FIXTURES_REQUIRED app_scene FIXTURES_SETUP compared LABELS "gpu;app" TIMEOUT 600)
set_tests_properties(compare.external PROPERTIES FIXTURES_REQUIRED "app_scene;compared" FIXTURES_SETUP compared_external
                     LABELS "gpu;app" TIMEOUT 600)
set_tests_properties(compare.summary PROPERTIES FIXTURES_REQUIRED compared
                     PASS_REGULAR_EXPRESSION "percentage points of gpvc on all of app_scene" LABELS app)
if(GPVC_NODE AND GPVC_CHROMIUM)
  add_test(NAME browser.report COMMAND ${GPVC_NODE} ${CMAKE_CURRENT_SOURCE_DIR}/../browser/report_browser.mjs ${compared}
                                       ${CMAKE_CURRENT_BINARY_DIR}/report_browser ${compared}/external)
  set_tests_properties(browser.report PROPERTIES FIXTURES_REQUIRED "compared;compared_external" LABELS "browser;app;nightly"
                       ENVIRONMENT "CHROMIUM=${GPVC_CHROMIUM}" TIMEOUT 600)
endif()

# The paper's page, of the accuracy benchmark's quick tables and the comparison above, which has the paper's smallest and
# largest epsilon alone.
if(GPVC_NODE AND GPVC_CHROMIUM AND GPVC_BENCHMARKS)
  set(paper ${CMAKE_CURRENT_BINARY_DIR}/paper)
  add_test(NAME paper.page
           COMMAND bash -c "rm -rf paper && mkdir -p paper/tables_1_to_6 && ln -s ${compared} paper/compare_city && \
echo test >paper/made_by.txt && $<TARGET_FILE:accuracy_benchmark> --quick -o paper/tables_1_to_6 >paper/accuracy.txt && \
${PROJECT_SOURCE_DIR}/benchmarks/reproduce_paper.sh --page paper")
  add_test(NAME browser.paper COMMAND ${GPVC_NODE} ${CMAKE_CURRENT_SOURCE_DIR}/../browser/paper_browser.mjs ${paper} ${paper}/looked_at)
  set_tests_properties(paper.page PROPERTIES FIXTURES_REQUIRED compared FIXTURES_SETUP paper_page LABELS "gpu;app;nightly"
                       SKIP_RETURN_CODE 77
                       WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR} TIMEOUT 600)
  set_tests_properties(browser.paper PROPERTIES FIXTURES_REQUIRED paper_page LABELS "browser;app;nightly"
                       ENVIRONMENT "CHROMIUM=${GPVC_CHROMIUM}" TIMEOUT 600)
endif()
