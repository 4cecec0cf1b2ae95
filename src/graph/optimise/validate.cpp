#include <wayfare/graph/detail/validate.hpp>

namespace wayfare {

template Result<void> validate_ends(const PoseGraph<SE2d>&, std::size_t);
template Result<void> validate_information(const PoseGraph<SE2d>&, std::size_t);
template Result<void> validate_edge(const PoseGraph<SE2d>&, std::size_t);
template Result<void> validate_edges(const PoseGraph<SE2d>&);
template Result<void> validate_connection(const PoseGraph<SE2d>&);
template Error cost_overflow(const PoseGraph<SE2d>&);
template Result<void> validate(const PoseGraph<SE2d>&);
template Result<void> validate_ends(const PoseGraph<SE3d>&, std::size_t);
template Result<void> validate_information(const PoseGraph<SE3d>&, std::size_t);
template Result<void> validate_edge(const PoseGraph<SE3d>&, std::size_t);
template Result<void> validate_edges(const PoseGraph<SE3d>&);
template Result<void> validate_connection(const PoseGraph<SE3d>&);
template Error cost_overflow(const PoseGraph<SE3d>&);
template Result<void> validate(const PoseGraph<SE3d>&);

}  // namespace wayfare
