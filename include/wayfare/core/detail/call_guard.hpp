#pragma once

#include <type_traits>
#include <utility>

#include <wayfare/core/result.hpp>

namespace wayfare::detail {

/// Knows whether a call that changes an object ended by an exception (std::bad_alloc): what it
/// changed is then incomplete, and later calls return an Error.
class CallGuard {
 public:
  /// The Result of `call()`, or the Error where an earlier call was interrupted.
  template <class Call>
  std::invoke_result_t<Call> run(Call&& call) {
    if (is_open_) return interrupted();
    is_open_ = true;
    std::invoke_result_t<Call> result = std::forward<Call>(call)();
    is_open_ = false;
    return result;
  }
  /// The object was set to a known state.
  void reset() { is_open_ = false; }

 private:
  [[nodiscard]] static Error interrupted() {
    return {ErrorCode::cancelled,
            "an exception (out of memory?) interrupted an earlier call: continue from a saved "
            "state, or start again"};
  }

  bool is_open_ = false;
};

}  // namespace wayfare::detail
