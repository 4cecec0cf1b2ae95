#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <vector>

#include <wayfare/graph/linear_solver.hpp>

#include "graph/cholesky/parallel.hpp"
#include "graph/cholesky/symbolic.hpp"

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

 private:
  static constexpr std::size_t kAlignment = 64, kSlack = 8;
  struct Free {
    void operator()(double* p) const { ::operator delete (p, std::align_val_t{kAlignment}); }
  };

  std::unique_ptr<double[], Free> data_;
  std::size_t size_ = 0;
};

/// The values of a multifrontal factorisation and their layout. The updates of a task are on two
/// stacks, for fronts at even and at odd depth, so that a front's update does not overlap those of
/// its children.
class Factor {
 public:
  /// The first `leading` numbers of a block share one unit, the others another.
  explicit Factor(FrontPlan plan, int leading);

  /// `h`: the values of the pattern's blocks. The rank of H is judged as in rank.hpp; the factor is
  /// void where the outcome is not ok. Bit-identical for any number of threads.
  FactorOutcome factorise(const double* h, int threads = 1);

  /// L y = x, then Lᵀ z = y, in the original order of columns.
  void solve_in_place(double* x);

  /// Computes the blocks of H⁻¹ in the pattern of L from the last successful factorisation.
  void invert();
  /// Block (row, column) of H⁻¹, in the original order, column-major; false if it is not in the
  /// pattern or `invert` was not called since the last factorisation.
  bool inverse_block(int row, int column, double* out) const;

 private:
  struct Place {
    std::size_t l11, l21, update;
    int ld11, ld21;
  };

  int eliminate(const double* h);
  FactorOutcome judge(const double* h, int failed);
  void place_fronts();
  void place_diagonal();
  void set_threads(int threads);
  void place_updates();
  void place_updates(std::size_t begin, std::size_t end, const std::vector<int>& depth);
  int factorise_front(std::size_t s, const double* h);
  bool loses_digits(std::size_t s, const double* h, const Panel& front);
  double estimate_shares(int k, std::vector<double>& most);
  [[nodiscard]] std::vector<double> response(std::size_t j);
  [[nodiscard]] double share(const std::vector<double>& v) const;
  [[nodiscard]] FactorOutcome find_undetermined();
  [[nodiscard]] Panel panel(std::size_t s, const AlignedDoubles& values) const;
  [[nodiscard]] Update update_of(int child) const;
  /// By the kernel `forward` or `backward`; y in the new numbering.
  void substitute(std::size_t s, const auto& kernel, double* y) {
    const Front& f = plan_.fronts[s];
    kernel(panel(s, values_), f.first, plan_.rows.data() + f.rows_begin, y, scratch_.data());
  }

  FrontPlan plan_;
  int leading_;
  std::vector<int> diagonal_;             // of each column, its block of H
  std::vector<double> scale_;             // D of rank.hpp
  std::size_t blocks_ = 0;                // of H
  std::atomic<bool> suspicious_ = false;  // a pivot of the last factorisation is small beside D
  const FrontKernels& kernels_;
  std::vector<Place> places_;
  TaskTree tasks_;
  int threads_ = 0;
  std::unique_ptr<TaskPool> pool_;  // null for one task
  std::size_t factor_size_ = 0, stack_size_ = 0, inverse_scratch_ = 0;
  int most_scratch_ = 0;
  AlignedDoubles values_, stack_, inverse_;
  bool inverted_ = false;
  std::vector<double> permuted_;
  AlignedDoubles scratch_;
};

}  // namespace wayfare::cholesky
