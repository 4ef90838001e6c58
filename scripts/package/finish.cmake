# What CPack runs on the tree of a package before it packs it: configuration goes to /etc, and texts are compressed as
# Debian's policy asks.
set(tree ${CPACK_TEMPORARY_INSTALL_DIRECTORY})
if(EXISTS ${tree}/usr/etc)
  file(RENAME ${tree}/usr/etc ${tree}/etc)
endif()
file(GLOB_RECURSE texts ${tree}/usr/share/man/* ${tree}/usr/share/doc/chequer/changelog)
foreach(text ${texts})
  execute_process(COMMAND gzip -9nf ${text} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
