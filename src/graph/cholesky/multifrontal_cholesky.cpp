#include <wayfare/graph/linear_solver.hpp>

#include <wayfare/core/contract.hpp>

#include "graph/cholesky/factor.hpp"

namespace wayfare {

template <int N>
void MultifrontalCholesky<N>::analyse(const BlockSparse<N>& h) {
  const cholesky::UpperPattern pattern{h.starts(), h.rows()};
  factor_ = detail::make_owned<cholesky::Factor>(
      cholesky::plan_fronts(pattern, cholesky::minimum_degree(pattern), N), leading_);
}

template <int N>
void MultifrontalCholesky<N>::set_threads(int threads) {
  WAYFARE_EXPECTS(threads > 0, "the number of threads must be positive");
  threads_ = threads;
}

template <int N>
FactorOutcome MultifrontalCholesky<N>::factorise(const BlockSparse<N>& h) {
  WAYFARE_EXPECTS(factor_ != nullptr, "analyse() must be called before factorise()");
  return factor_->factorise(h.blocks() > 0 ? h.data(0) : nullptr, threads_);
}

template <int N>
void MultifrontalCholesky<N>::solve_in_place(Eigen::VectorXd& x) {
  factor_->solve_in_place(x.data());
}

template <int N>
void MultifrontalCholesky<N>::invert() {
  factor_->invert();
}

template <int N>
bool MultifrontalCholesky<N>::inverse_block(int row, int column,
                                            Eigen::Matrix<double, N, N>& block) const {
  return factor_ && factor_->inverse_block(row, column, block.data());
}

template class MultifrontalCholesky<2>;
template class MultifrontalCholesky<3>;
template class MultifrontalCholesky<6>;

}  // namespace wayfare
