#include "tools/render_request.h"

namespace chequer {
namespace {

void AddCameraOptions(CLI::App& command, RenderRequest& request) {
  const char* group = "Camera";
  command.add_option("--camera-file", request.camera_file, "Calibration (TOML), instead of --size and a focal length")
      ->type_name("FILE")
      ->group(group);
  command.add_option("--size", request.size, "Of the frames, pixels")
      ->type_name("WIDTHxHEIGHT")
      ->capture_default_str()
      ->group(group);
  command.add_option("--focal", request.focal_px, "Focal length in pixels [0.75 of the width]")
      ->type_name("PX")
      ->group(group);
  command.add_option("--lens", request.lens_mm, "Focal length in mm; needs --pixel-pitch")
      ->type_name("MM")
      ->group(group);
  command.add_option("--pixel-pitch", request.pixel_pitch_um, "Of the sensor, in um")->type_name("UM")->group(group);
}

void AddSceneOptions(CLI::App& command, RenderRequest& request) {
  const char* group = "Scene";
  command.add_option("--swarm", request.swarm, "So many markers that move, at random places under a camera above them")
      ->type_name("N")
      ->group(group);
  command.add_option("--distance", request.distance_m, "From the camera, metres")
      ->type_name("M")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--position", request.position_m, "Of one marker, instead of --distance: metres right, down, away")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3)
      ->group(group);
  command.add_option("--heading", request.heading_deg, "Of one marker, degrees, clockwise")
      ->type_name("DEG")
      ->group(group);
  command.add_option("--tilt", request.tilt_deg, "Of one marker; of a swarm, the largest [5]")
      ->type_name("DEG")
      ->group(group);
  command.add_option("--tilt-axis", request.tilt_axis_deg, "About which one marker is tilted; 0 is the frame's x axis")
      ->type_name("DEG")
      ->group(group);
  command.add_option("--speed", request.max_speed_m_s, "Largest speed in a swarm, m/s")
      ->capture_default_str()
      ->group(group);
  command.add_option("--frames", request.frames, "How many")->capture_default_str()->group(group);
  command.add_option("--fps", request.fps, "Frames a second")->capture_default_str()->group(group);
  command.add_option("--peer", request.peer, "Draw tag36h11 or aruco4x4 instead; --side is of the black square")
      ->group(group);
  command.add_option("--ink", request.ink, "Of the print: " + InkNames())->capture_default_str()->group(group);
  command.add_option("--margin", request.margin_cells, "White margin round each board, in cells")->group(group);
  command.add_option("--ink-spread", request.ink_spread_cells, "By which dark cells grow on each side, in cells")
      ->group(group);
  command.add_option("--background", request.background, "An image file, or one of " + BackgroundNames())
      ->capture_default_str()
      ->group(group);
  command.add_option("--seed", request.seed, "Of everything random")->capture_default_str()->group(group);
}

void AddOpticsOptions(CLI::App& command, RenderRequest& request) {
  const char* group = "Lens, light and sensor";
  RenderOptions& camera = request.camera;
  const auto number = [&](const char* name, auto& value, const char* text) {
    command.add_option(name, value, text)->capture_default_str()->group(group);
  };
  number("--blur", camera.blur_sigma_px, "Of the lens: Gaussian sigma, pixels");
  number("--motion", camera.motion_px, "During the exposure, pixels");
  number("--motion-angle", request.motion_angle_deg, "Its direction: 0 right, 90 down");
  number("--exposure", camera.sensor.exposure, "1 puts white paper at 85 % of full scale");
  number("--gradient", camera.lighting.gradient, "Part of the light that is lost from side to side, 0..1");
  number("--gradient-angle", request.gradient_angle_deg, "Where it gets darker: 0 right, 90 down");
  number("--vignetting", camera.lighting.vignetting, "Part of the light that is lost in the corners, 0..1");
  number("--haze", camera.lighting.haze, "Part of the light that is veil, 0..0.95");
  command.add_option("--white-balance", request.white_balance, "Wrong factors of red, green and blue")
      ->type_name("R,G,B")
      ->delimiter(',')
      ->expected(3)
      ->group(group);
  number("--full-well", camera.sensor.full_well_electrons, "Electrons at full scale: fewer make more noise");
  number("--read-noise", camera.sensor.read_noise_electrons, "Electrons");
  command.add_option("--gamma", request.gamma, "Curve of the values instead of sRGB; 1 is linear")->group(group);
  command.add_option("--pixel-format", request.pixel_format, "Of the frames: " + PixelFormatNames())
      ->capture_default_str()
      ->group(group);
  command.add_option("--jpeg", request.jpeg_quality, "Write JPEG of that quality, 1..100")
      ->type_name("Q")
      ->group(group);
}

}  // namespace

void AddRenderOptions(CLI::App& command, RenderRequest& request) {
  AddMarkerOptions(command, request.markers);
  AddCameraOptions(command, request);
  AddSceneOptions(command, request);
  AddOpticsOptions(command, request);
  command.add_option("--out", request.out, "Folder of the recording; made if need be")->type_name("DIR")->required();
}

}  // namespace chequer
