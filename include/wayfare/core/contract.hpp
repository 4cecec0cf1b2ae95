#pragma once

// Contract violations: a failed precondition is reported to a handler, never returned as a result.
//
// The default handler writes the violation to standard error and aborts. Tests and safety-critical
// programs install their own. A handler may throw; if it returns, the call continues.

#include <atomic>
#include <cstdio>
#include <cstdlib>

namespace wayfare {

/// A precondition that did not hold.
struct ContractViolation {
  const char* condition;  ///< as written
  const char* message;    ///< what is required
  const char* file;       ///< of the check
  unsigned line;          ///< from 1
  const char* function;   ///< that checked
};

/// Called with a violation; see set_contract_handler.
using ContractHandler = void (*)(const ContractViolation&);

namespace detail {

inline void abort_on_violation(const ContractViolation& v) {
  std::fprintf(stderr, "%s:%u: precondition '%s' violated: %s\n", v.file, v.line, v.condition,
               v.message);
  std::abort();
}

inline std::atomic<ContractHandler>& contract_handler() noexcept {
  static std::atomic<ContractHandler> handler{&abort_on_violation};
  return handler;
}

inline void report_violation(const char* condition, const char* message,
                             const char* file = __builtin_FILE(), unsigned line = __builtin_LINE(),
                             const char* function = __builtin_FUNCTION()) {
  contract_handler().load()({condition, message, file, line, function});
}

}  // namespace detail

/// Installs `handler` (null restores the default) and returns the one it replaces.
inline ContractHandler set_contract_handler(ContractHandler handler) noexcept {
  return detail::contract_handler().exchange(handler != nullptr ? handler
                                                                : &detail::abort_on_violation);
}

}  // namespace wayfare

/// A precondition on the caller, checked in every build.
#define WAYFARE_EXPECTS(condition, message)                     \
  do {                                                          \
    if (!(condition)) [[unlikely]]                              \
      ::wayfare::detail::report_violation(#condition, message); \
  } while (false)
