#include <wayfare/graph/optimise.hpp>

namespace wayfare {

template class PoseGraphOptimiser<SE2d>;
template class PoseGraphOptimiser<SE3d>;

}  // namespace wayfare
