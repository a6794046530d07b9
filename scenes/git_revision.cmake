# Writes git_revision.cpp: cmake -DSOURCE=... -DOUTPUT=... -P git_revision.cmake. The file changes only when its
# content does, so that nothing is compiled in vain.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=12 --match=v*
  OUTPUT_VARIABLE GIT_REVISION OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed OR NOT GIT_REVISION MATCHES "^[A-Za-z0-9._-]+$")
  set(GIT_REVISION unknown)
endif()
configure_file(${SOURCE}/scenes/git_revision.cpp.in ${OUTPUT} @ONLY)
