# Finds Cyclone DDS 0.10 (Debian: cyclonedds-dev) by its pkg-config file, with the headers of its
# serialised data, which other versions do not install in this form.
#
# Defines the imported target CycloneDDS::ddsc.
include(FindPackageHandleStandardArgs)

find_package(PkgConfig QUIET)
if(PkgConfig_FOUND)
  pkg_check_modules(CYCLONEDDS QUIET IMPORTED_TARGET "CycloneDDS >= 0.10" "CycloneDDS < 0.11")
endif()
find_path(CYCLONEDDS_SERDATA_DIR dds/ddsi/q_radmin.h HINTS ${CYCLONEDDS_INCLUDEDIR}
          ${CYCLONEDDS_CycloneDDS_INCLUDEDIR})
mark_as_advanced(CYCLONEDDS_SERDATA_DIR)
find_package_handle_standard_args(CycloneDDS REQUIRED_VARS CYCLONEDDS_LINK_LIBRARIES
                                  CYCLONEDDS_SERDATA_DIR)

if(CycloneDDS_FOUND AND NOT TARGET CycloneDDS::ddsc)
  add_library(CycloneDDS::ddsc INTERFACE IMPORTED)
  target_link_libraries(CycloneDDS::ddsc INTERFACE PkgConfig::CYCLONEDDS)
endif()
