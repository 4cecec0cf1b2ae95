#pragma once

#include <memory>
#include <utility>

namespace wayfare::detail {

/// A unique_ptr that knows how to delete a type which is incomplete where its owner is moved or
/// destroyed: a class with its implementation in a source file need not declare these functions.
template <class T>
using Owned = std::unique_ptr<T, void (*)(T*)>;

template <class T, class... Arguments>
[[nodiscard]] Owned<T> make_owned(Arguments&&... arguments) {
  return {new T(std::forward<Arguments>(arguments)...), [](T* object) { delete object; }};
}

}  // namespace wayfare::detail
