// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/path_model.h"

#include <algorithm>
#include <cmath>

namespace cornice::flightlines {
namespace {

using Eigen::Vector3d;

/// Both returns err by sigma: at the sensor the line errs by sqrt(2) sigma range / length.
double expected_miss(const Observation& o, const Vector3d& d, double coordinate_sigma_m) {
  return coordinate_sigma_m * std::sqrt(0.5 + 2.0 * d.squaredNorm() / (o.pair_m * o.pair_m));
}

/// Normal of the plane, or axis of the cone, with its derivatives.
struct Axis {
  Vector3d m;
  Vector3d by_yaw = Vector3d::Zero(), by_side = Vector3d::Zero(), by_fore = Vector3d::Zero();
};

Axis plane_axis(const Seen& x, double yaw) {
  const double s = std::sin(yaw), c = std::cos(yaw);
  const double cp = std::cos(x(kAxisFore)), sp = std::sin(x(kAxisFore));
  Axis axis;
  axis.m = Vector3d(s * cp, c * cp, sp);
  axis.by_yaw = Vector3d(c * cp, -s * cp, 0.0);
  axis.by_fore = Vector3d(-s * sp, -c * sp, cp);
  return axis;
}

Axis cone_axis(const Seen& x) {
  const double s = std::sin(x(kHeading)), c = std::cos(x(kHeading));
  const Vector3d right(c, -s, 0.0), fore(s, c, 0.0);
  const Vector3d raw = x(kAxisSide) * right + x(kAxisFore) * fore - Vector3d::UnitZ();
  const double length = raw.norm();
  Axis axis;
  axis.m = raw / length;
  const auto turned = [&](const Vector3d& v) -> Vector3d {
    return (v - axis.m * axis.m.dot(v)) / length;
  };
  axis.by_yaw = turned(x(kAxisSide) * -fore + x(kAxisFore) * right);
  axis.by_side = turned(right);
  axis.by_fore = turned(fore);
  return axis;
}

Axis axis_of(const Seen& x, const Common& common, ScanModel model) {
  return model == ScanModel::kPlane ? plane_axis(x, x(kHeading) + common(kShape)) : cone_axis(x);
}

}  // namespace

Row angle_row(const Observation& o, const Seen& x, const Common& common) {
  const Vector3d d = o.p - x.head<3>();
  const double s = std::sin(x(kHeading)), c = std::cos(x(kHeading));
  const double u = c * d.x() - s * d.y();
  const double fore = s * d.x() + c * d.y();
  const double h = -d.z();
  const double square = std::max(u * u + h * h, 1.0);
  Row row;
  row.value = std::atan2(u, h) - o.angle - common(kOffset);
  row.by_state(0) = -h * c / square;
  row.by_state(1) = h * s / square;
  row.by_state(2) = -u / square;
  row.by_state(kHeading) = -h * fore / square;
  row.by_common(kOffset) = -1.0;
  return row;
}

double angle_value(const Observation& o, const Seen& x, const Common& common) {
  const Vector3d d = o.p - x.head<3>();
  const double u = std::cos(x(kHeading)) * d.x() - std::sin(x(kHeading)) * d.y();
  return std::atan2(u, -d.z()) - o.angle - common(kOffset);
}

Row scan_row(const Observation& o, const Seen& x, const Common& common, ScanModel model) {
  const Vector3d d = o.p - x.head<3>();
  const double range = std::max(d.norm(), 1.0);
  const Vector3d b = d / range;
  const Axis axis = axis_of(x, common, model);
  const double cosine = axis.m.dot(b);
  Row row;
  double slope = 1.0;
  if (model == ScanModel::kPlane) {
    row.value = cosine;
    row.by_common(kShape) = axis.by_yaw.dot(b);
  } else {
    const double angle = std::acos(std::clamp(cosine, -0.999999, 0.999999));
    slope = -1.0 / std::sin(angle);
    row.value = angle - common(kShape);
    row.by_common(kShape) = -1.0;
  }
  row.by_state.head<3>() = slope * -(axis.m - cosine * b) / range;
  row.by_state(kHeading) = slope * axis.by_yaw.dot(b);
  row.by_state(kAxisSide) = slope * axis.by_side.dot(b);
  row.by_state(kAxisFore) = slope * axis.by_fore.dot(b);
  return row;
}

double scan_value(const Observation& o, const Seen& x, const Common& common, ScanModel model) {
  const Vector3d d = o.p - x.head<3>();
  const double cosine = axis_of(x, common, model).m.dot(d) / std::max(d.norm(), 1.0);
  return model == ScanModel::kPlane
             ? cosine
             : std::acos(std::clamp(cosine, -0.999999, 0.999999)) - common(kShape);
}

void pair_rows(const Observation& o, const Seen& x, double coordinate_sigma_m, Row rows[2]) {
  const Vector3d d = x.head<3>() - o.p;
  const double expected = expected_miss(o, d, coordinate_sigma_m);
  for (const int i : {0, 1}) {
    const Vector3d& e = i == 0 ? o.e1 : o.e2;
    rows[i].value = e.dot(d) / expected;
    rows[i].by_state.head<3>() = e / expected;
  }
}

double pair_value(const Observation& o, const Seen& x, double coordinate_sigma_m) {
  const Vector3d d = x.head<3>() - o.p;
  return std::hypot(o.e1.dot(d), o.e2.dot(d)) / expected_miss(o, d, coordinate_sigma_m);
}

}  // namespace cornice::flightlines
