#include <wayfare/graph/detail/normal_equations.hpp>

#include <cmath>

#include <Eigen/Core>

namespace wayfare {

// In closed form: most blocks of PoseError's Jacobians are zero or the same rotation. In terms of
// X_i⁻¹ X_j = (R, t) and the measurement's rotation R_z, with W = R_z Ω_tt R_zᵀ: translations enter
// H as W at X_i, as −W R between, as Rᵀ W R at X_j.

void edge_terms(const PoseEdge<SE2d>& edge, const SE2d& from, const SE2d& to,
                EdgeTerms<SE2d>& out) {
  const auto &ri = from.rotation(), &rj = to.rotation(), &rz = edge.measurement.rotation();
  const Eigen::Matrix3d& o = edge.information;
  // (c, s) and (x, y): X_i⁻¹ X_j.
  const double dx = to.x() - from.x(), dy = to.y() - from.y();
  const double x = ri.cos() * dx + ri.sin() * dy, y = ri.cos() * dy - ri.sin() * dx;
  const double c = ri.cos() * rj.cos() + ri.sin() * rj.sin();
  const double s = ri.cos() * rj.sin() - ri.sin() * rj.cos();
  // Ω in the frame of X_i.
  const double cz = rz.cos(), sz = rz.sin();
  const double cc = cz * cz, cs = cz * sz, ss = sz * sz;
  const double wxx = cc * o(0, 0) - 2.0 * cs * o(0, 1) + ss * o(1, 1);
  const double wyy = ss * o(0, 0) + 2.0 * cs * o(0, 1) + cc * o(1, 1);
  const double wxy = cs * (o(0, 0) - o(1, 1)) + (cc - ss) * o(0, 1);
  const double wxa = cz * o(0, 2) - sz * o(1, 2), wya = sz * o(0, 2) + cz * o(1, 2);
  const double waa = o(2, 2);
  // The error, its translation too in the frame of X_i.
  const double ex = x - edge.measurement.x(), ey = y - edge.measurement.y();
  const double ea = std::atan2(s * cz - c * sz, c * cz + s * sz);
  const double fx = wxx * ex + wxy * ey + wxa * ea, fy = wxy * ex + wyy * ey + wya * ea;
  const double fa = wxa * ex + wya * ey + waa * ea;
  out.squared_error = not_negative(ex * fx + ey * fy + ea * fa);
  // J_from = −[1 0 −y; 0 1 x; 0 0 1] and J_to = [c −s 0; s c 0; 0 0 1] in the frame of X_i.
  const double pxa = wxa - y * wxx + x * wxy, pya = wya - y * wxy + x * wyy;
  const double paa = waa - y * wxa + x * wya;
  out.from << wxx, wxy, pxa, wxy, wyy, pya, pxa, pya, paa - y * pxa + x * pya;
  out.from_gradient << -fx, -fy, y * fx - x * fy - fa;
  out.to_gradient << c * fx + s * fy, c * fy - s * fx, fa;
  const double qxx = c * wxx + s * wxy, qxy = c * wxy - s * wxx;
  const double qyx = c * wxy + s * wyy, qyy = c * wyy - s * wxy;
  const double txa = c * wxa + s * wya, tya = c * wya - s * wxa;
  out.between << -qxx, -qxy, -wxa, -qyx, -qyy, -wya, -(c * pxa + s * pya), s * pxa - c * pya, -paa;
  const double txy = c * qxy + s * qyy;
  out.to << c * qxx + s * qyx, txy, txa, txy, c * qyy - s * qxy, tya, txa, tya, waa;
}

void edge_terms(const PoseEdge<SE3d>& edge, const SE3d& from, const SE3d& to,
                EdgeTerms<SE3d>& out) {
  using Block = Eigen::Matrix3d;
  using Vector = Eigen::Vector3d;
  const SE3d d = from.inverse() * to;
  const Block r = d.rotation().matrix(), rz = edge.measurement.rotation().matrix();
  const Vector& t = d.translation();
  Eigen::Quaterniond q = (edge.measurement.rotation().inverse() * d.rotation()).quaternion();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const Vector v = q.vec();
  // q ⊗ (1, δθ/2): the vector part moves by ½ (w I + [v]×) δθ.
  const Block turn = 0.5 * (q.w() * Block::Identity() + skew(v));
  const Block ott = edge.information.topLeftCorner<3, 3>();
  const Block otr = edge.information.topRightCorner<3, 3>();
  const Block orr = edge.information.bottomRightCorner<3, 3>();
  // The error's translation in the frame of X_i: R_z e_t.
  const Vector e = t - edge.measurement.translation();
  const Block w = rz * ott * rz.transpose();
  const Block cross = skew(t);
  const Block orr_turn = orr * turn;
  const Block wr = w * r;
  Vector f = w * e, h = orr * v;
  // Everything but what Ω_tr adds.
  const Block turned = turn.transpose() * orr_turn;
  const Block back = r * turned;
  Block between_tr = Block::Zero(), between_rt = -cross * wr;
  Block from_tr = -w * cross, to_tr = Block::Zero();
  Block between_rr = -back, from_rr = back * r.transpose() - cross * (w * cross);
  if (!otr.isZero(0.0)) {
    const Block x = rz * otr;
    const Block xt = x * turn, s = xt * r.transpose();  // seen from X_j's turn and from X_i's
    f += x * v;
    h += x.transpose() * e;
    between_tr = -xt;
    between_rt -= s.transpose() * r;
    to_tr = r.transpose() * xt;
    from_tr += s;
    between_rr -= cross * xt;
    const Block lever = cross * s;
    from_rr += lever + lever.transpose();
  }
  out.squared_error = not_negative(e.dot(f) + v.dot(h));
  const Vector turned_h = turn.transpose() * h;
  out.from_gradient << -f, -t.cross(f) - r * turned_h;
  out.to_gradient << r.transpose() * f, turned_h;
  out.from << w, from_tr, from_tr.transpose(), from_rr;
  out.between << -wr, between_tr, between_rt, between_rr;
  out.to << r.transpose() * wr, to_tr, to_tr.transpose(), turned;
}

template double squared_error(const PoseGraph<SE2d>&, const PoseEdge<SE2d>&);
template double squared_error(const PoseGraph<SE3d>&, const PoseEdge<SE3d>&);

template class NormalEquations<SE2d>;
template class NormalEquations<SE3d>;

}  // namespace wayfare
