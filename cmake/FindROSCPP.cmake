# Finds ROS 1's C++ client library as Debian packages it (libroscpp-dev), by its pkg-config file.
#
# Defines the imported target ROSCPP::ROSCPP. Its headers are C++17.
include(FindPackageHandleStandardArgs)

find_package(PkgConfig QUIET)
if(PkgConfig_FOUND)
  pkg_check_modules(PC_ROSCPP QUIET IMPORTED_TARGET roscpp)
endif()
find_package_handle_standard_args(ROSCPP REQUIRED_VARS PC_ROSCPP_LINK_LIBRARIES
                                  VERSION_VAR PC_ROSCPP_VERSION)

if(ROSCPP_FOUND AND NOT TARGET ROSCPP::ROSCPP)
  add_library(ROSCPP::ROSCPP INTERFACE IMPORTED)
  target_link_libraries(ROSCPP::ROSCPP INTERFACE PkgConfig::PC_ROSCPP)
endif()
