// MRPT's rbpf-slam on the same drives, with the settings of its configuration files: matching by
// ICP to a map of points (its file for the Intel log), and drawing from the optimal proposal on an
// occupancy grid (its file of that name), the grid's cells 5 cm as here.

#include <string>

#include <benchmark/benchmark.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose2D.h>
#include <mrpt/slam/CMetricMapBuilderRBPF.h>

#include "drive.hpp"

namespace wayfare {
namespace {

using Builder = mrpt::slam::CMetricMapBuilderRBPF;

mrpt::poses::CPose2D pose_of(const SE2d& T) { return {T.x(), T.y(), T.heading().radians()}; }

mrpt::obs::CObservation2DRangeScan::Ptr observation(const LaserScan& scan, const SE2d& mount) {
  auto out = mrpt::obs::CObservation2DRangeScan::Create();
  const std::size_t n = scan.ranges_m.size();
  out->aperture = static_cast<float>(scan.bearing_step.radians() * static_cast<double>(n - 1));
  out->rightToLeft = true;
  out->maxRange = scan.max_range_m;
  const Angle middle = scan.bearing(0) + scan.bearing_step * (0.5 * static_cast<double>(n - 1));
  out->sensorPose =
      mrpt::poses::CPose3D(pose_of(mount * SE2d(Eigen::Vector2d::Zero(), SO2d(middle))));
  out->resizeScan(n);
  for (std::size_t i = 0; i < n; ++i) {
    const bool returned = scan.returned(i);
    out->setScanRange(i, returned ? scan.ranges_m[i] : 0.0F);
    out->setScanRangeValidity(i, returned);
  }
  return out;
}

Builder::TConstructionOptions common(unsigned particles) {
  Builder::TConstructionOptions o;
  o.verbosity_level = mrpt::system::LVL_ERROR;
  // Every scan is used: the drive is thinned already.
  o.localizeLinDistance = 0.0F;
  o.localizeAngDistance = 0.0F;
  o.PF_options.sampleSize = particles;
  o.PF_options.BETA = 0.5;
  o.PF_options.resamplingMethod = mrpt::bayes::CParticleFilter::prMultinomial;
  return o;
}

Builder::TConstructionOptions icp_on_points(unsigned particles) {
  Builder::TConstructionOptions o = common(particles);
  o.insertionLinDistance = 2.0F;
  o.insertionAngDistance = mrpt::DEG2RAD(30.0F);
  o.PF_options.PF_algorithm = mrpt::bayes::CParticleFilter::pfOptimalProposal;
  mrpt::maps::CSimplePointsMap::TMapDefinition map;
  map.insertionOpts.minDistBetweenLaserPoints = 0.05F;
  map.insertionOpts.fuseWithExisting = false;
  map.insertionOpts.isPlanarMap = true;
  map.likelihoodOpts.max_corr_distance = 5.0;
  map.likelihoodOpts.sigma_dist = 0.05;
  o.mapsInitializers.push_back(map);
  auto& p = o.predictionOptions;
  p.pfOptimalProposal_mapSelection = 3;
  p.ICPGlobalAlign_MinQuality = 0.80F;
  p.icp_params.ICP_algorithm = mrpt::slam::icpLevenbergMarquardt;
  p.icp_params.maxIterations = 60;
  p.icp_params.thresholdDist = 1.0;
  p.icp_params.thresholdAng = mrpt::DEG2RAD(5.0);
  p.icp_params.ALFA = 0.5;
  p.icp_params.smallestThresholdDist = 0.10;
  p.icp_params.onlyUniqueRobust = false;
  return o;
}

Builder::TConstructionOptions optimal_on_grid(unsigned particles) {
  Builder::TConstructionOptions o = common(particles);
  o.insertionLinDistance = 1.0F;
  o.insertionAngDistance = mrpt::DEG2RAD(40.0F);
  o.PF_options.PF_algorithm = mrpt::bayes::CParticleFilter::pfAuxiliaryPFOptimal;
  o.PF_options.powFactor = 0.01;
  o.PF_options.pfAuxFilterOptimal_MaximumSearchSamples = 400;
  mrpt::maps::COccupancyGridMap2D::TMapDefinition map;
  map.resolution = 0.05F;
  map.insertionOpts.maxDistanceInsertion = 35;
  map.insertionOpts.maxOccupancyUpdateCertainty = 0.60F;
  map.insertionOpts.considerInvalidRangesAsFreeSpace = true;
  map.insertionOpts.wideningBeamsWithDistance = false;
  map.likelihoodOpts.likelihoodMethod = mrpt::maps::COccupancyGridMap2D::lmLikelihoodField_Thrun;
  map.likelihoodOpts.LF_decimation = 5;
  map.likelihoodOpts.LF_stdHit = 0.20F;
  map.likelihoodOpts.LF_maxCorrsDistance = 0.30F;
  map.likelihoodOpts.LF_zHit = 0.999F;
  map.likelihoodOpts.LF_zRandom = 0.001F;
  map.likelihoodOpts.LF_maxRange = 30;
  map.likelihoodOpts.LF_alternateAverageMethod = false;
  map.likelihoodOpts.enableLikelihoodCache = true;
  o.mapsInitializers.push_back(map);
  o.predictionOptions.pfOptimalProposal_mapSelection = 0;
  return o;
}

/// σ as in the benchmark of this library: 3 cm + 25 %, 3° + 20 %.
mrpt::obs::CActionRobotMovement2D::TMotionModelOptions motion_model() {
  mrpt::obs::CActionRobotMovement2D::TMotionModelOptions o;
  o.modelSelection = mrpt::obs::CActionRobotMovement2D::mmGaussian;
  o.gaussianModel.a1 = 0.25;
  o.gaussianModel.a2 = 0.0;
  o.gaussianModel.a3 = 0.0;
  o.gaussianModel.a4 = 0.2;
  o.gaussianModel.minStdXY = 0.03;
  o.gaussianModel.minStdPHI = 0.05;
  return o;
}

/// The time is the total CPU time per particle and scan.
void particle_scan(benchmark::State& state, const std::string& name,
                   Builder::TConstructionOptions (*options_of)(unsigned)) {
  const Drive& drive = drive_of(name);
  if (drive.scans.empty()) return state.SkipWithError("no such recording in WAYFARE_DATA_DIR");
  const auto particles = static_cast<unsigned>(state.range(0));
  const auto model = motion_model();
  for (auto _ : state) {
    const double start = cpu_seconds();
    Builder builder(options_of(particles));
    builder.setVerbosityLevel(mrpt::system::LVL_ERROR);
    builder.mapPDF.setMinLoggingLevel(mrpt::system::LVL_ERROR);
    builder.initialize();
    for (std::size_t i = 0; i < drive.scans.size(); ++i) {
      mrpt::obs::CActionRobotMovement2D motion;
      motion.computeFromOdometry(pose_of(drive.increments[i]), model);
      motion.timestamp = mrpt::Clock::fromDouble(drive.scans[i].time.seconds());
      mrpt::obs::CActionCollection action;
      action.insert(motion);
      mrpt::obs::CSensoryFrame frame;
      frame.insert(observation(drive.scans[i], drive.T_base_laser));
      builder.processActionObservation(action, frame);
    }
    const double took = cpu_seconds() - start;
    if (builder.mapPDF.particlesCount() != particles) state.SkipWithError("particles lost");
    state.SetIterationTime(took / static_cast<double>(drive.scans.size()) /
                           static_cast<double>(particles));
  }
}
void once(benchmark::internal::Benchmark* b) {
  b->Arg(10)->UseManualTime()->Iterations(1)->Unit(benchmark::kMicrosecond);
}
BENCHMARK_CAPTURE(particle_scan, Fr079Icp, "fr079", icp_on_points)
    ->Name("particle_scan_fr079/mrpt_icp_points")
    ->Apply(once);
BENCHMARK_CAPTURE(particle_scan, Fr079Grid, "fr079", optimal_on_grid)
    ->Name("particle_scan_fr079/mrpt_optimal_grid")
    ->Apply(once);
BENCHMARK_CAPTURE(particle_scan, IntelIcp, "intel", icp_on_points)
    ->Name("particle_scan_intel/mrpt_icp_points")
    ->Apply(once);
BENCHMARK_CAPTURE(particle_scan, IntelGrid, "intel", optimal_on_grid)
    ->Name("particle_scan_intel/mrpt_optimal_grid")
    ->Apply(once);

}  // namespace
}  // namespace wayfare
