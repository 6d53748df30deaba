message(STATUS "skipped: the Python module cannot be tested, as there is no ${REASON}")
