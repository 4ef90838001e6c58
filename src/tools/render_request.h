#pragma once

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/recording_writer.h"
#include "simulate/print_quality.h"
#include "simulate/render.h"
#include "tools/marker_options.h"

namespace chequer {

/// What `chequer render` is asked for, as typed.
struct RenderRequest {
  std::string config;                ///< supplies what the others leave out
  std::optional<CameraSetup> setup;  ///< what it says, once it is read
  std::string scenario;              ///< file of a stream, instead of all but seed and folder

  // The camera.
  std::string camera_file;
  std::string size = "1920x1080";
  bool size_typed = false;
  std::optional<double> focal_px;
  std::optional<double> lens_mm;
  std::optional<double> pixel_pitch_um;

  // What stands before it.
  MarkerOptions markers;
  std::string peer;                   ///< "tag36h11" or "aruco4x4" instead of colour checkerboards
  std::vector<std::string> position;  ///< lengths: right, down, away
  double distance_m = 3;
  double heading_deg = 0;
  double tilt_deg = 0;
  double tilt_axis_deg = 0;
  int swarm = 0;
  bool sheet = false;  ///< a printed sheet that is held before the camera
  std::string room;    ///< list of references: a room seen from above
  std::string world;   ///< of the room; empty: the configuration's
  std::string robots;  ///< of the room; empty: the configuration's
  double max_speed_m_s = 0.5;
  int frames = 1;
  double fps = 60;
  std::string print = "ideal";       ///< a kind
  std::vector<double> print_scale;   ///< of width and height; empty: the kind's
  std::optional<double> register_m;  ///< not set, as the three that follow: the kind's
  std::optional<double> fading, dirt, gloss;
  std::string bend;                      ///< a length, or 0; empty: the kind's
  std::optional<double> bend_angle_deg;  ///< not set: each print's own
  std::optional<std::string> ink;        ///< not set: the kind's
  double margin_cells = 0;
  double ink_spread_cells = 0;
  std::string background = "plain";  ///< a kind, or an image file

  // How it is seen.
  RenderOptions camera;  ///< its camera model, tone curve and format are set from the other options
  double motion_angle_deg = 0;
  double gradient_angle_deg = 0;
  std::optional<double> gamma;
  std::string preset;  ///< of a kind of camera: what it sets, options override
  std::optional<double> chromatic_aberration_px, denoising_levels, sharpening, saturation, upscaling;
  std::string camera_curve;
  std::string pixel_format;  ///< empty: the preset's, or BGR8
  std::optional<int> jpeg_quality;
  std::vector<double> white_balance{1, 1, 1};
  std::uint64_t seed = 1;

  std::string out;  ///< folder
};

/// Adds those of the options that describe the camera: --camera-file, --size, --focal, --lens and --pixel-pitch.
void AddRenderCameraOptions(CLI::App& command, RenderRequest& request);
/// The camera that they describe; of a configuration where they describe none. Throws CLI::ValidationError,
/// std::runtime_error where the file is not right.
CameraModel PlanCamera(const RenderRequest& request);

/// Adds the options of `chequer render`. `request` must outlive the parsing.
void AddRenderOptions(CLI::App& command, RenderRequest& request);

/// What a request means.
struct RenderJob {
  RenderOptions options;
  FrameFileOptions files;
  Background background;
  int frames = 1;
  double fps = 60;
  std::uint64_t seed = 1;
  std::function<std::vector<SceneMarker>(std::chrono::duration<double>)> markers_at;

  /// Of a frame since the first.
  std::chrono::duration<double> TimeOf(int frame) const { return std::chrono::duration<double>(frame / fps); }
};

/// How the markers of a request are printed.
struct MarkerPrint {
  InkSet inks;
  double ink_spread_cells = 0;
  PrintQuality quality;
};
/// @param widest_m the longest side of what is printed in one piece: it must not bend by more than 1 rad.
/// Throws CLI::ValidationError naming the option.
MarkerPrint PlanMarkerPrint(const RenderRequest& request, double widest_m);

/// Throws CLI::ValidationError naming the option, what is wrong and what would be right; std::runtime_error where a
/// file cannot be read or where a swarm finds no room.
RenderJob PlanRender(const RenderRequest& request);

}  // namespace chequer
