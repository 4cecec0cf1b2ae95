#pragma once

#include <type_traits>

namespace wayfare {

/// A number that says nothing of its unit. Types with a unit delete their constructor from it, on
/// one line with the remedy: compilers quote that line.
template <class T>
concept BareNumber = std::is_arithmetic_v<T>;

}  // namespace wayfare
