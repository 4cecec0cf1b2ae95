# Install and export rules, one export set and one pkg-config file a component, following the global
# property WAYFARE_BUILT_COMPONENTS that wayfare_component() fills.
include(CMakePackageConfigHelpers)

set(_wayfare_package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/wayfare")
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME dev)

# What a component needs, read from the target itself so that nobody keeps a second list: other
# components by name, foreign packages as the namespace of their target (ZLIB::ZLIB -> ZLIB).
function(_wayfare_requirements component components_out packages_out)
  get_target_property(libraries wayfare_${component} INTERFACE_LINK_LIBRARIES)
  set(components "")
  set(packages "")
  foreach(library IN LISTS libraries)
    string(REGEX REPLACE "^\\$<LINK_ONLY:(.*)>$" "\\1" library "${library}")
    if(library MATCHES "^wayfare(::|_)(.+)$")
      list(APPEND components "${CMAKE_MATCH_2}")
    elseif(library MATCHES "^([A-Za-z0-9_]+)::")
      list(APPEND packages "${CMAKE_MATCH_1}")
    elseif(library AND NOT library MATCHES "^::@")
      message(FATAL_ERROR "wayfare_${component} links '${library}'; link imported targets only, "
                          "a bare library name does not survive installation")
    endif()
  endforeach()
  list(REMOVE_DUPLICATES components)
  list(REMOVE_DUPLICATES packages)
  set(${components_out} "${components}" PARENT_SCOPE)
  set(${packages_out} "${packages}" PARENT_SCOPE)
endfunction()

# A static library's needs are all Requires, not Requires.private: whoever links it links them.
function(_wayfare_pkg_config _component _needs _packages)
  set(_pc_requires "")
  set(_pc_libs "")
  set(_pc_cflags "")
  get_target_property(_type wayfare_${_component} TYPE)
  if(_type STREQUAL "STATIC_LIBRARY")
    set(_pc_libs " -L\${libdir} -lwayfare_${_component}")
  endif()
  foreach(_need IN LISTS _needs)
    list(APPEND _pc_requires "wayfare-${_need} = ${PROJECT_VERSION}")
  endforeach()
  foreach(_package IN LISTS _packages)
    list(APPEND _pc_requires ${WAYFARE_${_package}_REQUIRES})
    string(APPEND _pc_libs " ${WAYFARE_${_package}_LIBS}")
    string(APPEND _pc_cflags " ${WAYFARE_${_package}_CFLAGS}")
  endforeach()
  string(REGEX REPLACE " +" " " _pc_libs "${_pc_libs}")
  string(REGEX REPLACE "^ | $" "" _pc_libs "${_pc_libs}")
  string(CONFIGURE "-I\${includedir}${_pc_cflags}" _pc_cflags @ONLY)
  string(STRIP "${_pc_cflags}" _pc_cflags)
  list(JOIN _pc_requires ", " _pc_requires)
  file(RELATIVE_PATH _to_prefix "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
  string(REGEX REPLACE "/$" "" _to_prefix "${_to_prefix}")
  configure_file("${PROJECT_SOURCE_DIR}/cmake/component.pc.in"
                 "${PROJECT_BINARY_DIR}/pkgconfig/wayfare-${_component}.pc" @ONLY)
  install(FILES "${PROJECT_BINARY_DIR}/pkgconfig/wayfare-${_component}.pc"
          DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
endfunction()

get_property(_components GLOBAL PROPERTY WAYFARE_BUILT_COMPONENTS)
set(_requirements "")
set(_wayfare_foreign "")  # packages of all components
foreach(_component IN LISTS _components)
  install(TARGETS wayfare_${_component} EXPORT wayfare-${_component}
          ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}"
          LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}"
          RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
  install(EXPORT wayfare-${_component} NAMESPACE wayfare::
          FILE wayfare-${_component}-targets.cmake DESTINATION "${_wayfare_package_dir}")
  _wayfare_requirements(${_component} _needs _packages)
  _wayfare_pkg_config(${_component} "${_needs}" "${_packages}")
  list(APPEND _wayfare_foreign ${_packages})
  string(APPEND _requirements "set(_wayfare_${_component}_components ${_needs})\n"
                              "set(_wayfare_${_component}_packages ${_packages})\n")
  foreach(_package IN LISTS _packages)
    if(EXISTS "${PROJECT_SOURCE_DIR}/cmake/Find${_package}.cmake")
      install(FILES "${PROJECT_SOURCE_DIR}/cmake/Find${_package}.cmake"
              DESTINATION "${_wayfare_package_dir}")
    endif()
  endforeach()
endforeach()
list(REMOVE_DUPLICATES _wayfare_foreign)
foreach(_package IN LISTS _wayfare_foreign)
  wayfare_debian_of(_debian ${_package})
  string(APPEND _requirements "set(_wayfare_debian_of_${_package} \"${_debian}\")\n")
endforeach()
get_property(_left_out GLOBAL PROPERTY WAYFARE_LEFT_OUT)
foreach(_line IN LISTS _left_out)
  string(REGEX MATCH "^([^ ]+) (.*)$" _line "${_line}")
  string(APPEND _requirements "set(_wayfare_${CMAKE_MATCH_1}_left_out \"${CMAKE_MATCH_2}\")\n")
endforeach()
list(JOIN _components " " WAYFARE_INSTALLED_COMPONENTS)
set(WAYFARE_COMPONENT_REQUIREMENTS "${_requirements}")

configure_package_config_file(
  "${PROJECT_SOURCE_DIR}/cmake/wayfareConfig.cmake.in" "${PROJECT_BINARY_DIR}/wayfareConfig.cmake"
  INSTALL_DESTINATION "${_wayfare_package_dir}"
  NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
# Before 1.0 a new minor version may break its users.
write_basic_package_version_file("${PROJECT_BINARY_DIR}/wayfareConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/wayfareConfig.cmake"
              "${PROJECT_BINARY_DIR}/wayfareConfigVersion.cmake"
        DESTINATION "${_wayfare_package_dir}")
install(DIRECTORY "${PROJECT_SOURCE_DIR}/include/wayfare" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}"
        FILES_MATCHING PATTERN "*.hpp")
