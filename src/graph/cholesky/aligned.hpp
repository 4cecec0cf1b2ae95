#pragma once

#include <cstddef>
#include <memory>
#include <new>

namespace wayfare::cholesky {

/// Numbers on a cache line's border, not initialised, with room to read a vector past their end.
/// A handle: who may look may write.
class AlignedDoubles {
 public:
  /// Keeps what it has where that is enough.
  void reserve(std::size_t size) {
    if (size <= size_ && data_) return;
    data_.reset();  // first, so that there is never both
    data_.reset(static_cast<double*>(
        ::operator new ((size + kSlack) * sizeof(double), std::align_val_t{kAlignment})));
    size_ = size;
  }
  [[nodiscard]] double* data() const { return data_.get(); }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  static constexpr std::size_t kAlignment = 64, kSlack = 8;
  struct Free {
    void operator()(double* p) const { ::operator delete (p, std::align_val_t{kAlignment}); }
  };

  std::unique_ptr<double[], Free> data_;
  std::size_t size_ = 0;
};

}  // namespace wayfare::cholesky
