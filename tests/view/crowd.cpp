// crowd CAMERAS MARKERS SECONDS: publishes what so many cameras would, 30 frames a second each, with a status a second
// and ten small pictures a second. For measuring what the view and its page take.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "capture/jpeg.h"
#include "core/clock.h"
#include "publish/lcm_publisher.h"
#include "publish/lcm_sink.h"
#include "publish/wire_view.h"

namespace {

using namespace chequer;
using std::chrono::microseconds;

constexpr int kWidth = 1920, kHeight = 1080;
constexpr double kFocal = 1000, kDistanceM = 3;

CameraMessage CameraOf(int index) {
  CameraMessage camera;
  camera.camera = "crowd" + std::to_string(index);
  camera.model = CameraModel{.width = kWidth,
                             .height = kHeight,
                             .fx = kFocal,
                             .fy = kFocal,
                             .cx = kWidth / 2.0,
                             .cy = kHeight / 2.0,
                             .kind = CameraModel::Kind::kBrownConrady,
                             .distortion = {-0.05, 0.01, 0, 0, 0}};
  camera.world_from_camera =
      RigidTransform{RotationFromVector({M_PI, 0, 0}), {6.0 * (index % 5), 3.4 * (index / 5), kDistanceM}};
  camera.families = {{Variant::kSecded, {6, 6}, 0.12}};
  return camera;
}

void Move(PosesMessage& message, int markers, double time_s) {
  message.markers.resize(static_cast<std::size_t>(markers));
  const int columns = static_cast<int>(std::ceil(std::sqrt(markers * 16.0 / 9)));
  for (int i = 0; i < markers; ++i) {
    MarkerPose& marker = message.markers[static_cast<std::size_t>(i)];
    marker.id = static_cast<std::uint64_t>(i);
    marker.has_pose = true;
    marker.corners_used = 25;
    marker.reprojection_rms_px = 0.05;
    marker.covariance = Matrix6d::Identity() * 1e-7;
    const double angle = time_s + i, rows = std::ceil(markers / static_cast<double>(columns));
    const double x = (i % columns + 0.5) / columns * 5.2 - 2.6 + 0.05 * std::cos(angle);
    const double y = (i / columns + 0.5) / rows * 2.9 - 1.45 + 0.05 * std::sin(angle);
    marker.camera_from_marker = {RotationFromVector({M_PI, 0, 0}) * RotationFromVector({0, 0, angle}),
                                 {x, y, kDistanceM}};
    marker.center_px = {kWidth / 2.0 + kFocal * x / kDistanceM, kHeight / 2.0 + kFocal * y / kDistanceM};
    if (i % 10 == 0) marker.warnings = static_cast<std::uint32_t>(Warning::kPartlyHidden);
  }
}

std::vector<std::uint8_t> SomePicture() {
  Image image(PixelFormat::kBgr8, 320, 180);
  for (std::size_t i = 0; i < image.bytes().size(); ++i)
    image.bytes()[i] = static_cast<std::uint8_t>(90 + (i / 3 % 320) / 8 + i / 9600);
  return JpegFromImage(image.view(), {.quality = 75, .chroma = ChromaSharing::k420});
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const int cameras = std::atoi(argv[1]), markers = std::atoi(argv[2]);
  const Clock clock = Clock::System();
  const std::string url = "udpm://239.255.76.67:7667?ttl=0";
  std::string problem;
  const auto sink = OpenLcmSink(ParseLcmUrl(url, LcmDirection::kPublish), clock, problem);
  if (!sink) return std::fprintf(stderr, "%s\n", problem.c_str()), 1;
  std::vector<std::unique_ptr<LcmPublisher>> publishers;
  for (int i = 0; i < cameras; ++i)
    publishers.push_back(
        std::make_unique<LcmPublisher>(LcmPublisherOptions{.url = url, .prefix = "CHEQUER_crowd" + std::to_string(i)}));
  const std::vector<std::uint8_t> jpeg = SomePicture();
  PosesMessage poses;
  poses.image_width = kWidth;
  poses.image_height = kHeight;
  const MonotonicTime begin = clock.monotonic();
  const auto steps = static_cast<std::uint64_t>(30.0 * cameras * std::atof(argv[3]));
  // Cameras take turns, so that their frames come evenly.
  for (std::uint64_t step = 0; step < steps; ++step) {
    std::this_thread::sleep_until(begin + microseconds(1'000'000 * step / static_cast<std::uint64_t>(30 * cameras)));
    const int camera = static_cast<int>(step % static_cast<std::uint64_t>(cameras));
    const std::string prefix = "CHEQUER_crowd" + std::to_string(camera);
    poses.camera = "crowd" + std::to_string(camera);
    poses.sequence = step / static_cast<std::uint64_t>(cameras);
    poses.captured_utc = poses.published_utc = clock.utc();
    poses.captured_monotonic = poses.published_monotonic = clock.monotonic();
    Move(poses, markers, static_cast<double>(step) / (30.0 * cameras));
    LcmPublisher& publisher = *publishers[static_cast<std::size_t>(camera)];
    publisher.Publish(poses);
    if (poses.sequence % 30 == 0) {
      StatusMessage status;
      status.utc = clock.utc();
      status.camera = poses.camera;
      status.camera_state = CameraState::kRunning;
      status.uptime = std::chrono::seconds(poses.sequence / 30);
      status.capture_rate_hz = status.publish_rate_hz = 30;
      status.markers_mean = markers;
      publisher.Publish(status);
      sink->Send(prefix + "_CAMERA", EncodeView(CameraOf(camera)));
    }
    if (poses.sequence % 3 == 0) {
      const PreviewMessage preview{.captured_utc = poses.captured_utc,
                                   .sequence = poses.sequence,
                                   .camera = poses.camera,
                                   .asker = 0,
                                   .image_width = kWidth,
                                   .image_height = kHeight,
                                   .region = {0, 0, kWidth, kHeight},
                                   .width = 320,
                                   .height = 180,
                                   .jpeg = jpeg};
      sink->Send(prefix + "_PREVIEW", EncodeView(preview));
    }
  }
}
