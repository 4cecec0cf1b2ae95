#pragma once

#include <type_traits>

namespace wayfare {

/// A number without a unit. Types with a unit delete their constructor from it, with the
/// alternative on the same line, which compilers quote.
template <class T>
concept BareNumber = std::is_arithmetic_v<T>;

}  // namespace wayfare
