#pragma once

// Other libraries as reference, run by node and installed by npm when a test runs.

#include <cstdio>
#include <string>

namespace wayfare::testing {

inline std::string output_of(const std::string& command, int& status) {
  std::string out;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return status = -1, out;
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;)
    out.append(buffer, n);
  status = ::pclose(pipe);
  return out;
}

/// Empty if `module` is installed in `folder`, beside its package.json; else the reason.
inline std::string peer_missing(const std::string& folder, const std::string& module) {
  int status = 0;
  output_of("node --version 2>/dev/null", status);
  if (status != 0) return "needs node (package nodejs)";
  const std::string in = "cd '" + folder + "' && ";
  output_of(in + "node -e 'import(\"" + module + "\")' 2>/dev/null", status);
  if (status == 0) return {};
  output_of(in + "timeout 60 npm install --no-audit --no-fund --loglevel=error 2>&1", status);
  return status == 0 ? "" : "needs " + module + ", which `npm install` could not bring";
}

}  // namespace wayfare::testing
