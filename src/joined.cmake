# Files that are compiled together where CMAKE_UNITY_BUILD asks for it. CMake would deal them out in the order of their
# list, so that after a new file all others had to be compiled anew.

# chequer_join(TARGET [PATTERN...]): a target's files go with those of the first pattern that they match; the others where
# their names' hash puts them.
function(chequer_join target)
  if(NOT CMAKE_UNITY_BUILD)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  get_target_property(most_joined ${target} UNITY_BUILD_BATCH_SIZE)
  list(LENGTH sources count)
  math(EXPR batches "(${count} + ${most_joined} - 1) / ${most_joined}")
  foreach(source IN LISTS sources)
    string(REPLACE "${PROJECT_SOURCE_DIR}/" "" name ${source})
    string(MD5 hash ${name})
    string(SUBSTRING ${hash} 0 4 digits)
    math(EXPR batch "0x${digits} % ${batches}")
    foreach(pattern IN LISTS ARGN)
      if(name MATCHES ${pattern})
        string(MAKE_C_IDENTIFIER ${pattern} batch)
        break()
      endif()
    endforeach()
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP "joined_${batch}")
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
endfunction()
