# Run while installing: PROGRAMS as wayfare-NAME, stripped, each with the man page and the completion
# that it prints itself, and the copyright and the changelogs of the Debian package PACKAGE.
set(root "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}")
get_filename_component(source "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)

function(compress file)
  execute_process(COMMAND gzip -9nf "${file}" COMMAND_ERROR_IS_FATAL ANY)
endfunction()

foreach(program IN LISTS PROGRAMS)
  get_filename_component(name "${program}" NAME)
  set(name "wayfare-${name}")
  file(INSTALL "${program}" DESTINATION "${CMAKE_INSTALL_PREFIX}/bin" TYPE PROGRAM RENAME "${name}")
  set(installed "${root}/bin/${name}")
  file(RPATH_REMOVE FILE "${installed}")  # some libraries of others add their folder
  if(STRIP)
    execute_process(COMMAND "${STRIP}" "${installed}" COMMAND_ERROR_IS_FATAL ANY)
  endif()
  file(MAKE_DIRECTORY "${root}/share/man/man1" "${root}/share/bash-completion/completions")
  execute_process(COMMAND "${installed}" --man-page OUTPUT_FILE "${root}/share/man/man1/${name}.1"
                  COMMAND_ERROR_IS_FATAL ANY)
  compress("${root}/share/man/man1/${name}.1")
  execute_process(COMMAND "${installed}" --bash-completion
                  OUTPUT_FILE "${root}/share/bash-completion/completions/${name}"
                  COMMAND_ERROR_IS_FATAL ANY)
endforeach()

set(documents "${root}/share/doc/${PACKAGE}")
file(READ "${source}/LICENSE" licence)
string(REGEX MATCH "Copyright \\(c\\) ([^\n]+)" copyright "${licence}")
set(copyright "${CMAKE_MATCH_1}")
string(FIND "${licence}" "Permission is" begin)
string(SUBSTRING "${licence}" ${begin} -1 licence)
string(STRIP "${licence}" licence)
string(REPLACE "\n\n" "\n.\n" licence "${licence}")
string(REPLACE "\n" "\n " licence "${licence}")
file(WRITE "${documents}/copyright"
"Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: wayfare

Files: *
Copyright: ${copyright}
License: Expat
 ${licence}
")
# SOURCE_DATE_EPOCH, if set, makes the date reproducible.
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE "${documents}/changelog.Debian"
"wayfare (${VERSION}-1) unstable; urgency=medium

  * Packaged by CPack; changes are in changelog.gz.

 -- ${MAINTAINER}  ${date}
")
configure_file("${source}/CHANGELOG.md" "${documents}/changelog" COPYONLY)
compress("${documents}/changelog.Debian")
compress("${documents}/changelog")
file(GLOB_RECURSE written "${documents}/*" "${root}/share/man/*" "${root}/share/bash-completion/*")
foreach(file IN LISTS written)
  file(CHMOD "${file}" PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
endforeach()
