# Debian packages by CPack: `cpack --config build/CPackConfig.cmake` writes libwayfare-dev (component
# dev: headers, static libraries, CMake and pkg-config files, documents), wayfare-tools (component
# tools: the programs, as wayfare-NAME, with man pages and completions) and, where Cyclone DDS or roscpp
# is, wayfare-ros-nodes. `cmake --install` without a component installs dev alone.
set(_tools "")
set(_nodes "")
if(WAYFARE_BUILD_EXAMPLES)
  get_property(_programs GLOBAL PROPERTY WAYFARE_PROGRAMS)
  foreach(_program IN LISTS _programs)
    get_target_property(_dir ${_program} SOURCE_DIR)
    if(_dir MATCHES "/examples/programs/ros_nodes$")
      list(APPEND _nodes "$<TARGET_FILE:${_program}>")
    elseif(_dir MATCHES "/examples/programs/")
      list(APPEND _tools "$<TARGET_FILE:${_program}>")
    endif()
  endforeach()
endif()

# _wayfare_package(COMPONENT DEBIAN-NAME PROGRAM...): programs and what every Debian package has.
function(_wayfare_package component name)
  install(CODE "set(PACKAGE ${name})
set(PROGRAMS \"${ARGN}\")
set(VERSION ${PROJECT_VERSION})
set(STRIP \"${CMAKE_STRIP}\")
set(MAINTAINER \"${CPACK_PACKAGE_CONTACT}\")
include(\"${PROJECT_SOURCE_DIR}/cmake/install_package.cmake\")"
          COMPONENT ${component} ${_exclude})
endfunction()

set(CPACK_PACKAGE_CONTACT "The wayfare authors <wayfare@packages.invalid>" CACHE STRING
    "Maintainer of the Debian packages")
_wayfare_package(dev libwayfare-dev)
install(FILES "${PROJECT_SOURCE_DIR}/README.md" DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/libwayfare-dev")
install(DIRECTORY "${PROJECT_SOURCE_DIR}/docs" DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/libwayfare-dev"
        PATTERN decisions EXCLUDE PATTERN "Doxyfile" EXCLUDE PATTERN "*.awk" EXCLUDE)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/examples/tour"
        DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/libwayfare-dev/examples")
set(CPACK_COMPONENTS_ALL dev)
set(_exclude EXCLUDE_FROM_ALL)  # of an installation, not of the packages
if(_tools)
  _wayfare_package(tools wayfare-tools ${_tools})
  list(APPEND CPACK_COMPONENTS_ALL tools)
endif()
if(_nodes)
  _wayfare_package(ros_nodes wayfare-ros-nodes ${_nodes})
  list(APPEND CPACK_COMPONENTS_ALL ros_nodes)
endif()

# What find_package(wayfare) without components needs is a dependency, the rest a suggestion.
set(_optional GTest nlohmann_json CHOLMOD ROSCPP CycloneDDS)
set(_depends "")
set(_suggests "")
foreach(_package IN LISTS _wayfare_foreign _optional)
  if(_package IN_LIST _optional)
    list(APPEND _suggests ${WAYFARE_${_package}_DEBIAN})
  else()
    list(APPEND _depends ${WAYFARE_${_package}_DEBIAN})
  endif()
endforeach()
list(REMOVE_DUPLICATES _suggests)
list(JOIN _depends ", " CPACK_DEBIAN_DEV_PACKAGE_DEPENDS)
list(JOIN _suggests ", " CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME wayfare)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE
    GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libwayfare-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME wayfare-tools)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_ROS_NODES_PACKAGE_NAME wayfare-ros-nodes)
set(CPACK_DEBIAN_ROS_NODES_PACKAGE_SECTION science)
set(CPACK_DEBIAN_ROS_NODES_PACKAGE_SHLIBDEPS ON)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_COMPONENT_DEV_DESCRIPTION
"Header-mostly C++20 library: LiDAR and radar SLAM, Monte-Carlo localisation,
inertial navigation with GNSS, attitude and pedestrian dead reckoning.
Static libraries, CMake and pkg-config files.")
set(CPACK_COMPONENT_TOOLS_DESCRIPTION
"Programs for recordings: SLAM, localisation, inertial navigation, attitude and
pedestrian dead reckoning; simulators, decoders, a logger of devices and its
monitor. Every program is called wayfare-NAME and has a man page.")
set(CPACK_COMPONENT_ROS_NODES_DESCRIPTION
"ROS nodes: SLAM and pedestrian dead reckoning on live messages, drivers of an
AWR1843 and an RPLIDAR, a recorder and a player of recordings; for the systems,
ROS 1 and ROS 2, whose libraries were there when they were built.")
include(CPack)
