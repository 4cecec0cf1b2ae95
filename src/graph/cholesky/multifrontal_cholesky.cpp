#include <wayfare/graph/multifrontal_cholesky.hpp>

#include <wayfare/core/contract.hpp>

#include "graph/cholesky/factor.hpp"

namespace wayfare {

MultifrontalFactor::MultifrontalFactor() = default;
MultifrontalFactor::MultifrontalFactor(MultifrontalFactor&&) noexcept = default;
MultifrontalFactor& MultifrontalFactor::operator=(MultifrontalFactor&&) noexcept = default;
MultifrontalFactor::~MultifrontalFactor() = default;

void MultifrontalFactor::analyse(std::span<const int> starts, std::span<const int> rows, int block,
                                 int leading) {
  const cholesky::UpperPattern pattern{starts, rows};
  factor_ = std::make_unique<cholesky::Factor>(
      cholesky::plan_fronts(pattern, cholesky::minimum_degree(pattern), block), leading);
}

void MultifrontalFactor::set_threads(int threads) {
  WAYFARE_EXPECTS(threads > 0, "the number of threads must be positive");
  threads_ = threads;
}

FactorOutcome MultifrontalFactor::factorise(const double* values) {
  WAYFARE_EXPECTS(factor_ != nullptr, "analyse() must be called before factorise()");
  return factor_->factorise(values, threads_);
}

void MultifrontalFactor::solve_in_place(double* x) { factor_->solve_in_place(x); }

void MultifrontalFactor::invert() { factor_->invert(); }

bool MultifrontalFactor::inverse_block(int row, int column, double* out) const {
  return factor_ && factor_->inverse_block(row, column, out);
}

}  // namespace wayfare
