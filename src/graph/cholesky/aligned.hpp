#pragma once

#include <cstddef>
#include <memory>
#include <new>

namespace wayfare::cholesky {

/// An uninitialised array aligned to a cache line, with slack to read a vector past its end. A
/// handle: const access does not prevent writing.
class AlignedDoubles {
 public:
  /// Reallocates only if the array is too small.
  void reserve(std::size_t size) {
    if (size <= size_ && data_) return;
    data_.reset();  // first, so that both never exist together
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
