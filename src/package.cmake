# The package: units and what goes with them, and how CPack makes a .deb of all that is installed: `cpack` in the build
# directory.
set(units ${PROJECT_SOURCE_DIR}/systemd)
install(FILES ${units}/chequerd@.service ${units}/chequer.target ${units}/chequer-multicast.service
  ${units}/chequer-view.service
  DESTINATION lib/systemd/system)
install(FILES ${units}/drop-ins/network-camera.conf ${units}/drop-ins/realtime.conf
  DESTINATION ${CMAKE_INSTALL_DATADIR}/chequer/systemd)
install(FILES ${units}/60-chequer.rules DESTINATION lib/udev/rules.d)
install(FILES ${units}/60-chequer.conf DESTINATION etc/sysctl.d)
install(FILES ${PROJECT_SOURCE_DIR}/config/chequerd.toml DESTINATION etc/chequer RENAME example.toml)

set(CPACK_PACKAGE_CONTACT_ADDRESS maintainers@chequer.invalid)
set(package ${PROJECT_SOURCE_DIR}/scripts/package)
configure_file(${package}/changelog.in ${CMAKE_CURRENT_BINARY_DIR}/package/changelog @ONLY)
install(FILES ${package}/copyright ${CMAKE_CURRENT_BINARY_DIR}/package/changelog DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES ${package}/overrides DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides RENAME chequer)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME chequer)
set(CPACK_PACKAGE_CONTACT "chequer maintainers <${CPACK_PACKAGE_CONTACT_ADDRESS}>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "tracks swarms of robots by colour checkerboards")
set(CPACK_PACKAGE_DESCRIPTION
"Every robot carries a colour checkerboard; a camera looks down on them. The
daemon chequerd reads its frames, finds and identifies the markers and
publishes every frame's poses over LCM, as a service of systemd for each
camera. The package also brings chequer, the tool for everything else, and the
web page that shows what they do, and the
detector as a library for programs of one's own.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PRE_BUILD_SCRIPTS ${package}/finish.cmake)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "iproute2, libjs-chart.js, systemd (>= 252)")
# What a program needs that is built against the library.
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libeigen3-dev, liblcm-dev, bash-completion")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${package}/conffiles ${package}/triggers ${package}/postinst ${package}/prerm ${package}/postrm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
