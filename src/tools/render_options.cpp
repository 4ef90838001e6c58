#include "simulate/print_quality.h"
#include "tools/length_option.h"
#include "tools/number_check.h"
#include "tools/render_request.h"
#include "tools/setup_option.h"

namespace chequer {
namespace {

/// A lab to try before there is one.
void AddLabOptions(CLI::App& command, RenderRequest& request) {
  const char* group = "A lab";
  command
      .add_flag("--sheet", request.sheet,
                "The sheet that chequer print makes of these markers, held before the camera another way in each frame")
      ->group(group);
  command
      .add_option("--room", request.room,
                  "Markers on the floor at the places of this list (chequer-world.toml(5)), robots among them, seen "
                  "from above")
      ->type_name("FILE")
      ->group(group);
  command
      .add_option("--world", request.world,
                  "Where the camera of the room hangs [the configuration's; else --distance over its middle]")
      ->type_name("FILE")
      ->group(group);
  command
      .add_option("--robots", request.robots,
                  "Roster of the room's robots [the configuration's; else one for each of --ids that is not on the "
                  "floor]")
      ->type_name("FILE")
      ->group(group);
}

/// What is printed, and how well.
void AddPrintOptions(CLI::App& command, RenderRequest& request) {
  const char* group = "Print";
  command
      .add_option("--print", request.print,
                  "How well the markers are printed; each is drawn by the seed. The truth has those that were meant: " +
                      PrintKindNames())
      ->type_name("KIND")
      ->capture_default_str()
      ->group(group);
  command.add_option("--print-scale", request.print_scale, "Printed over nominal width and height, such as 1.005,1")
      ->type_name("X,Y")
      ->delimiter(',')
      ->expected(2)
      ->check(IsWithin(0.9, 1.1))
      ->group(group);
  AddLengthOption(command, "--register", request.register_m,
                  "How far blue and yellow lie off black along either axis, standard deviation")
      ->group(group);
  command.add_option("--fading", request.fading, "Share by which inks are nearer to white")
      ->check(IsWithin(0, 0.9))
      ->group(group);
  command.add_option("--dirt", request.dirt, "Share of each board under dark specks")
      ->check(IsWithin(0, 0.3))
      ->group(group);
  command
      .add_option(
          "--gloss", request.gloss,
          "The mirror image of a lamp on each print: what it adds at its middle, over what white paper reflects. "
          "Toner has to 1, laminated paper more [0]")
      ->check(IsWithin(0, 5))
      ->group(group);
  command
      .add_option("--bend", request.bend,
                  "Radius of the cylinder that the paper lies on, such as 1m; -1m where it is hollow, 0 where it is "
                  "flat. Poses are of a marker's middle; a sheet bends as a whole")
      ->type_name("RADIUS")
      ->group(group);
  command
      .add_option("--bend-angle", request.bend_angle_deg,
                  "In which the paper bends, degrees from a marker's x axis towards its y axis [each print its own]")
      ->check(IsWithin(-360, 360))
      ->type_name("DEG")
      ->group(group);
  command.add_option("--ink", request.ink, "Of the print, if not the kind's: " + InkNames())->group(group);
}

void AddSceneOptions(CLI::App& command, RenderRequest& request) {
  const char* group = "Scene";
  command.add_option("--swarm", request.swarm, "So many markers that move, at random places under a camera above them")
      ->type_name("N")
      ->group(group);
  AddLengthOption(command, "--distance", request.distance_m, "From the camera")->default_str("3m")->group(group);
  command
      .add_option("--position", request.position,
                  "Of one marker, instead of --distance: right, down, away, as 0.5,-20cm,3")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3)
      ->group(group);
  command.add_option("--heading", request.heading_deg, "Of one marker, degrees, clockwise")
      ->check(IsWithin(-360, 360))
      ->type_name("DEG")
      ->group(group);
  command.add_option("--tilt", request.tilt_deg, "Of one marker, to 89; of a swarm the largest, to 68 [5]")
      ->check(IsWithin(-89, 89))
      ->type_name("DEG")
      ->group(group);
  command.add_option("--tilt-axis", request.tilt_axis_deg, "About which one marker is tilted; 0 is the frame's x axis")
      ->check(IsWithin(-360, 360))
      ->type_name("DEG")
      ->group(group);
  command.add_option("--speed", request.max_speed_m_s, "Largest speed in a swarm, m/s")
      ->check(IsWithin(0, 1000))
      ->capture_default_str()
      ->group(group);
  command.add_option("--frames", request.frames, "How many")->capture_default_str()->group(group);
  command.add_option("--fps", request.fps, "Frames a second")->capture_default_str()->group(group);
  command.add_option("--peer", request.peer, "Draw tag36h11 or aruco4x4 instead; --side is of the black square")
      ->group(group);
  AddPrintOptions(command, request);
  command.add_option("--margin", request.margin_cells, "White margin round each board, in cells")
      ->check(IsWithin(0, 20))
      ->group(group);
  command.add_option("--ink-spread", request.ink_spread_cells, "By which dark cells grow on each side, in cells")
      ->check(IsWithin(0, 0.4))
      ->group(group);
  command.add_option("--background", request.background, "An image file, or one of " + BackgroundNames())
      ->capture_default_str()
      ->group(group);
  command.add_option("--seed", request.seed, "Of everything random")
      ->check(IsWhole())
      ->capture_default_str()
      ->group(group);
}

void AddOpticsOptions(CLI::App& command, RenderRequest& request) {
  const char* group = "Lens, light and sensor";
  RenderOptions& camera = request.camera;
  const auto number = [&](const char* name, auto& value, double min, double max, const char* text) {
    command.add_option(name, value, text)->check(IsWithin(min, max))->capture_default_str()->group(group);
  };
  number("--blur", camera.blur_sigma_px, 0, 20, "Of the lens: Gaussian sigma, pixels");
  number("--motion", camera.motion_px, 0, 200, "During the exposure, pixels");
  number("--motion-angle", request.motion_angle_deg, -360, 360, "Its direction: 0 right, 90 down");
  number("--exposure", camera.sensor.exposure, 1e-6, 1000, "1 puts white paper at 85 % of full scale");
  number("--gradient", camera.lighting.gradient, 0, 1, "Part of the light that is lost from side to side, 0..1");
  number("--gradient-angle", request.gradient_angle_deg, -360, 360, "Where it gets darker: 0 right, 90 down");
  number("--vignetting", camera.lighting.vignetting, 0, 1, "Part of the light that is lost in the corners, 0..1");
  number("--haze", camera.lighting.haze, 0, 0.95, "Part of the light that is veil, 0..0.95");
  command.add_option("--white-balance", request.white_balance, "Wrong factors of red, green and blue")
      ->type_name("R,G,B")
      ->delimiter(',')
      ->expected(3)
      ->group(group);
  number("--full-well", camera.sensor.full_well_electrons, 1, 1e9, "Electrons at full scale: fewer make more noise");
  number("--read-noise", camera.sensor.read_noise_electrons, 0, 1e6, "Electrons");
  command.add_option("--gamma", request.gamma, "Curve of the values instead of sRGB; 1 is linear")->group(group);
  command.add_option("--pixel-format", request.pixel_format, "Of the frames: " + PixelFormatNames() + " [BGR8]")
      ->group(group);
  command.add_option("--jpeg", request.jpeg_quality, "Write JPEG of that quality, 1..100")
      ->type_name("Q")
      ->group(group);
}

/// What webcams do to pictures.
void AddProcessingOptions(CLI::App& command, RenderRequest& request) {
  const char* group = "Processing";
  command
      .add_option("--camera", request.preset,
                  "A kind of camera, which sets what follows, --pixel-format and --jpeg where they are not given: " +
                      CameraPresetNames())
      ->group(group);
  const auto number = [&](const char* name, std::optional<double>& value, double min, double max, const char* text) {
    command.add_option(name, value, text)->check(IsWithin(min, max))->group(group);
  };
  number("--chromatic-aberration", request.chromatic_aberration_px, 0, 5,
         "Red is so many pixels too far out in the corners, and blue too far in [0]");
  number("--denoising", request.denoising_levels, 0, 50, "Levels that a bilateral filter takes for noise [0]");
  number("--sharpening", request.sharpening, 0, 4, "Unsharp masking of 1 px: how much of it [0]");
  number("--saturation", request.saturation, 0, 3, "Factor of the colours' distance from grey [1]");
  command
      .add_option("--camera-curve", request.camera_curve,
                  std::string("Curve of the values that recording.toml does not tell of: ") + kCameraCurveForms)
      ->group(group);
  number("--upscaling", request.upscaling, 1, 4, "By which the sensor's pixels are fewer than the frame's [1]");
}

}  // namespace

void AddRenderCameraOptions(CLI::App& command, RenderRequest& request) {
  const char* group = "Camera";
  command
      .add_option("--camera-file,--calibration", request.camera_file,
                  "Calibration (TOML), instead of --size and a focal length")
      ->type_name("FILE")
      ->group(group);
  command.add_option("--size", request.size, "Of the frames, pixels")
      ->type_name("WIDTHxHEIGHT")
      ->capture_default_str()
      ->each([&request](const std::string&) { request.size_typed = true; })
      ->group(group);
  command.add_option("--focal", request.focal_px, "Focal length in pixels [0.75 of the width]")
      ->type_name("PX")
      ->group(group);
  AddLengthOption(command, "--lens", request.lens_mm, "Focal length, such as 12mm or 12 (mm); needs --pixel-pitch",
                  1e-3)
      ->group(group);
  AddLengthOption(command, "--pixel-pitch,--pixel", request.pixel_pitch_um,
                  "Of the sensor, such as 3.45um or 3.45 (um)", 1e-6)
      ->group(group);
}

void AddRenderOptions(CLI::App& command, RenderRequest& request) {
  command
      .add_option("--scenario", request.scenario, "A stream (TOML) in phases; all but --seed and --out is said there")
      ->type_name("FILE");
  AddSetupOption(command, request.config, "camera file, markers, world and roster");
  AddMarkerOptions(command, request.markers);
  AddRenderCameraOptions(command, request);
  AddSceneOptions(command, request);
  AddLabOptions(command, request);
  AddOpticsOptions(command, request);
  AddProcessingOptions(command, request);
  command.add_option("--out", request.out, "Folder of the recording; made if need be")->type_name("DIR")->required();
}

}  // namespace chequer
