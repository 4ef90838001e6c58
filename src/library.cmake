# libchequer: what finds markers in an image of one's own, as one shared library and a CMake package. It is made of the
# objects of the modules, so it is the same code as the daemon's. The public headers turn visibility on for what they
# declare; everything else is hidden.
add_library(chequer SHARED
  $<TARGET_OBJECTS:chequer_core> $<TARGET_OBJECTS:chequer_marker> $<TARGET_OBJECTS:chequer_detect>)
add_library(chequer::chequer ALIAS chequer)
set_target_properties(chequer PROPERTIES
  LINKER_LANGUAGE CXX
  VERSION ${PROJECT_VERSION}
  # Before 1.0 a new minor version may break the binary interface.
  SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
target_compile_features(chequer INTERFACE cxx_std_20)
target_link_libraries(chequer
  PUBLIC Eigen3::Eigen
  PRIVATE hwy::hwy tomlplusplus::tomlplusplus $<BUILD_INTERFACE:chequer_build_flags>)
target_sources(chequer PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR}/include FILES
  ${PROJECT_SOURCE_DIR}/include/chequer/camera_file.h
  ${PROJECT_SOURCE_DIR}/include/chequer/camera_model.h
  ${PROJECT_SOURCE_DIR}/include/chequer/detect_trace.h
  ${PROJECT_SOURCE_DIR}/include/chequer/detector.h
  ${PROJECT_SOURCE_DIR}/include/chequer/detector_memory.h
  ${PROJECT_SOURCE_DIR}/include/chequer/geometry.h
  ${PROJECT_SOURCE_DIR}/include/chequer/image.h
  ${PROJECT_SOURCE_DIR}/include/chequer/marker.h
  ${PROJECT_SOURCE_DIR}/include/chequer/tone_curve.h)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/chequer)
install(TARGETS chequer EXPORT chequer_targets FILE_SET HEADERS)
install(EXPORT chequer_targets NAMESPACE chequer:: FILE chequerTargets.cmake DESTINATION ${package_dir})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/chequerConfig.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/chequerConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/chequerConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/chequerConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/chequerConfigVersion.cmake
  DESTINATION ${package_dir})
