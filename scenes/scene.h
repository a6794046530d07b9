#pragma once
/// A scene: how many frames of which world, and what is written of them.
#include <string>
#include <vector>

#include "coupling/world_params.h"
#include "scenes/preview.h"

namespace wick::scenes {

enum class Precision { half, single };
enum class UpAxis { z, y };
enum class VelocityUnit { second, frame };

/// Names of the volume grids, for renderers that look for others.
struct GridNames {
  std::string density = "density";
  std::string temperature = "temperature";
  std::string flame = "flame";
  std::string velocity = "vel";
};
void describe(ParameterVisitor& visitor, GridNames& params);

/// Values nearer to the background than this are not stored.
struct ClipParams {
  double density = 1e-5;     ///< [kg/m3]
  double temperature = 0.5;  ///< from ambient [K]
  double flame = 1e-3;
  double velocity = 1e-3;  ///< [m/s]
};
void describe(ParameterVisitor& visitor, ClipParams& params);

struct VolumeParams {
  bool write = true;
  Precision precision = Precision::half;
  VelocityUnit velocity_unit = VelocityUnit::second;
  GridNames names;
  ClipParams clip;
};
void describe(ParameterVisitor& visitor, VolumeParams& params);

struct MeshOutputParams {
  bool write = true;
};
void describe(ParameterVisitor& visitor, MeshOutputParams& params);

/// Movement of the sheets, to be given to a later run as shells/*/motion.
struct MotionOutputParams {
  bool write = false;
};
void describe(ParameterVisitor& visitor, MotionOutputParams& params);

struct CheckpointParams {
  int every = 10;  ///< frames; 0: only on a signal and at the end
  int keep = 3;
};
void describe(ParameterVisitor& visitor, CheckpointParams& params);

struct OutputParams {
  UpAxis up_axis = UpAxis::z;
  int frame_start = 1;
  int frame_padding = 4;
  VolumeParams volume;
  MeshOutputParams mesh;
  MotionOutputParams motion;
  PreviewParams preview;
  CheckpointParams checkpoint;
};
void describe(ParameterVisitor& visitor, OutputParams& params);

struct Scene {
  std::string name = "scene";
  int frames = 100;
  double fps = 24.0;
  coupling::WorldParams world;
  OutputParams output;
  std::vector<std::string> warnings = {};  ///< of reading it, each with its pointer in front; not a parameter
};
void describe(ParameterVisitor& visitor, Scene& scene);

/// Checks what no single parameter can: names that would write the same file twice.
void require_valid(const Scene& scene);

}  // namespace wick::scenes
