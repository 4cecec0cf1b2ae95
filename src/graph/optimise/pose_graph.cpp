#include <wayfare/graph/optimise.hpp>

namespace wayfare {

template class DampedStep<SE2d, MultifrontalCholesky<3>>;
template class DampedStep<SE3d, MultifrontalCholesky<6>>;
template bool gauss_newton(DampedStep<SE2d, MultifrontalCholesky<3>>&, PoseGraph<SE2d>&,
                           const OptimiseOptions&, OptimiseReport&);
template Result<void> levenberg_marquardt(DampedStep<SE2d, MultifrontalCholesky<3>>&,
                                          PoseGraph<SE2d>&, const OptimiseOptions&,
                                          OptimiseReport&);
template bool gauss_newton(DampedStep<SE3d, MultifrontalCholesky<6>>&, PoseGraph<SE3d>&,
                           const OptimiseOptions&, OptimiseReport&);
template Result<void> levenberg_marquardt(DampedStep<SE3d, MultifrontalCholesky<6>>&,
                                          PoseGraph<SE3d>&, const OptimiseOptions&,
                                          OptimiseReport&);

template class PoseGraphOptimiser<SE2d>;
template class PoseGraphOptimiser<SE3d>;

}  // namespace wayfare
