#include "support/mixed_frames.h"

#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "simulate/render.h"
#include "simulate/stress.h"
#include "support/scenes.h"
#include "support/stream_frames.h"

namespace chequer::test {
namespace {

/// How the bytes of a frame are coded, by turns.
struct Coding {
  PixelFormat format;
  ToneCurve tone_curve;
};

Coding CodingOf(std::size_t turn) {
  const std::array<Coding, 7> codings{{{PixelFormat::kBgr8, ToneCurve::Srgb()},
                                       {PixelFormat::kBayerRg8, ToneCurve::Linear()},
                                       {PixelFormat::kBgr8, ToneCurve::Gamma(2.2)},
                                       {PixelFormat::kMono8, ToneCurve::Srgb()},
                                       {PixelFormat::kBayerGb8, ToneCurve::Srgb()},
                                       {PixelFormat::kYuyv, ToneCurve::Srgb()},
                                       {PixelFormat::kNv12, ToneCurve::Srgb()}}};
  return codings[turn % codings.size()];
}

void Code(const Coding& coding, RenderOptions& options) {
  options.tone_curve = coding.tone_curve;
  if (!options.jpeg_quality) options.format = coding.format;
}

MarkerCode Secded() { return MarkerCode({6, 6}, Variant::kSecded); }

/// Boards of 9 px cells in three columns and two rows.
Scene SixBoards(const CameraModel& camera) {
  constexpr double kCellPx = 9;
  const double depth = camera.fx * kMixedSideM / 6 / kCellPx;
  Scene scene;
  for (int i = 0; i < 6; ++i) {
    const double x = (i % 3 - 1) * 100 + 3.3 * i, y = (i / 3 - 0.5) * 110 - 2.7 * i;
    scene.markers.push_back(MarkerOf(
        Secded(), static_cast<std::uint64_t>(100 + i),
        FacingPose({x * depth / camera.fx, y * depth / camera.fx, depth}, 0.4 + i, 0.05 * i, 2.0 * i), kMixedSideM));
  }
  return scene;
}

/// What makes a frame hard.
struct Trouble {
  const char* name;
  std::function<void(Scene&, RenderOptions&)> make;
};

void Hide(Scene& scene, double part, int patches) {
  for (SceneMarker& marker : scene.markers)
    marker.occluders = {{.from = {-0.1, -0.1}, .to = {1.1, part}, .patches = patches, .seed = 3}};
}

void Tilt(Scene& scene, double tilt_rad) {
  for (std::size_t i = 0; i < scene.markers.size(); ++i) {
    RigidTransform& pose = scene.markers[i].camera_from_marker;
    pose = FacingPose(pose.translation, static_cast<double>(i), tilt_rad, 0.5 + static_cast<double>(i));
  }
}

std::vector<Trouble> Troubles() {
  const auto smear = [](double px) {
    return [px](Scene&, RenderOptions& o) { o.motion_px = px, o.motion_angle_rad = 0.3 + px; };
  };
  const auto shade = [](Scene&, RenderOptions& o) {
    o.shadow = {.takes = 0.6, .direction_rad = 0.5, .through_x = o.camera.cx, .through_y = o.camera.cy, .width_px = 3};
  };
  const auto spread = [](Scene& s, RenderOptions&) {
    for (SceneMarker& marker : s.markers) marker.ink_spread_cells = 0.12;
  };
  return {{"smeared by 4 px", smear(4)},
          {"smeared by 8 px", smear(8)},
          {"smeared by 12 px", smear(12)},
          {"hidden strips", [](Scene& s, RenderOptions&) { Hide(s, 0.2, 0); }},
          {"hidden strips with patches", [](Scene& s, RenderOptions&) { Hide(s, 0.34, 8); }},
          {"edge of a shadow", shade},
          {"spread ink", spread},
          {"out of focus", [](Scene&, RenderOptions& o) { o.blur_sigma_px = 2.5; }},
          {"edge of a shadow out of focus", [shade](Scene& s, RenderOptions& o) { shade(s, o), o.blur_sigma_px = 2; }},
          {"dim", [](Scene&, RenderOptions& o) { o.sensor.exposure = 0.05; }},
          {"overexposed", [](Scene&, RenderOptions& o) { o.sensor.exposure = 1.8; }},
          {"steep", [](Scene& s, RenderOptions&) { Tilt(s, 1.32); }},
          {"one board", [](Scene& s, RenderOptions&) { s.markers.resize(1); }},
          {"no board", [](Scene& s, RenderOptions&) { s.markers.clear(); }}};
}

}  // namespace

CameraModel MixedCamera() { return PlainCamera(640, 480, 600); }

std::vector<NamedFrame> StressFrames() {
  std::vector<NamedFrame> frames;
  for (const std::uint64_t seed : {11u, 12u})
    for (StressCase& stress : StressCases(Secded(), seed)) {
      Code(CodingOf(frames.size()), stress.options);
      frames.push_back({"stress " + stress.tag, Render(stress.scene, stress.options, seed)});
    }
  return frames;
}

std::vector<NamedFrame> TroubledFrames(std::size_t most) {
  std::vector<NamedFrame> frames;
  // Smaller and larger than the frames before it, too.
  const std::array<CameraModel, 3> cameras{MixedCamera(), PlainCamera(400, 300, 600), PlainCamera(800, 600, 700)};
  for (const Trouble& trouble : Troubles()) {
    if (frames.size() >= most) return frames;
    const std::size_t turn = frames.size() / 2;
    RenderOptions options;
    options.camera = cameras[turn % 5 < 3 ? 0 : turn % 5 - 2];
    Code(CodingOf(turn), options);
    Scene scene = SixBoards(options.camera);
    const Image calm = Render(scene, options, turn);
    trouble.make(scene, options);
    frames.push_back({trouble.name, Render(scene, options, turn)});
    frames.push_back({std::string("calm after ") + trouble.name, calm});
  }
  for (const KnownFrame& clutter : ClutterFrames(7, 9)) frames.push_back({clutter.name, clutter.Draw()});
  frames.push_back({"12 x 12", Image(PixelFormat::kBgr8, 12, 12)});
  frames.push_back({"16 x 16", Image(PixelFormat::kMono8, 16, 16)});
  return frames;
}

std::vector<NamedFrame> StreamSample() {
  std::vector<NamedFrame> frames;
  const auto take = [&](const char* of, const StreamFrames& stream, std::size_t every) {
    for (std::size_t i = every / 2; i < stream.size(); i += every)
      frames.push_back({of + (" stream, " + stream.phase(i)) + ", frame " + std::to_string(i), stream.Frame(i).image});
  };
  take("reference", StreamFrames::Example("reference"), 15);
  std::string others = R"(
seed = 4
[camera]
size = "640x480"
focal_px = 1800
distance = 3.0
[swarm]
robots = 6
side = 0.1
)";
  for (const char* kind : {"flicker", "shadow", "traffic", "turn", "knock", "reopen", "calm"})
    others += std::string("[[phase]]\nkind = \"") + kind + "\"\nframes = 12\n";
  take("small", StreamFrames(others), 4);
  return frames;
}

}  // namespace chequer::test
