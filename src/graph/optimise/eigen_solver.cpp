#include <wayfare/graph/eigen_solver.hpp>

namespace wayfare {

template class ScalarSolver<
    3, Eigen::SimplicialLLT<ScalarExpansion<3>::Matrix, Eigen::Upper, Eigen::NaturalOrdering<int>>>;
template class ScalarSolver<
    6, Eigen::SimplicialLLT<ScalarExpansion<6>::Matrix, Eigen::Upper, Eigen::NaturalOrdering<int>>>;

}  // namespace wayfare
