// What is wrong, and what to do about it: in one place, for every page.

/// Of a marker's warnings: what each says, what to do, and "good" where it is no fault.
export const warningAdvice = {
  id_undecided: ['the board is certain, its identity is not', 'Look at its cells: hidden or doubtful ones decide. More light, a sharper picture or a larger marker helps.'],
  poor_illumination: ['dark and light cells overlap', 'Open the exposure, or light the floor more evenly; look for glare on the print.'],
  poor_white_balance: ['plain and saturated cells overlap', 'Set the white balance by hand under this light; automatic ones drift.'],
  partly_hidden: ['cells or corners were not seen', 'Something lies over it, or it leaves the frame. The pose holds; its covariance says how well.'],
  ambiguous_pose: ['the mirrored tilt explains the picture nearly as well', 'It is seen nearly from above and small: a larger marker or a longer lens settles it. Position and heading hold.'],
  id_carried: ['the id is known from earlier frames, not read in this one', 'Nothing to do while it moves; see its cells if it lasts.'],
  poor_fit: ['the picture says much that the model does not explain', 'Glare, a bent print or a wrong side length; the covariance is widened.'],
  levels_learnt: ['the pose rests on cell levels of earlier frames, too', 'Nothing: learn_levels is on. Errors of successive frames go together.', 'good'],
};

const hints = {
  hint_black: ['frames are black', 'Take off the lens cap; open the exposure.'],
  hint_white: ['frames are white', 'Shorten the exposure or lower the gain.'],
  hint_no_contrast: ['frames have no contrast', 'Open the exposure; look for fog on the lens.'],
  hint_blurred: ['frames are blurred', 'Focus the lens on the height of the markers.'],
  hint_no_board: ['nothing looks like a board', 'Is a marker in view, and large enough? A cell needs 4 pixels.'],
  hint_no_border: ['patterns lack the border of the size that is sought', 'Compare size in [[marker]] with the print.'],
  hint_mirrored: ['boards are mirrored', 'Turn off the camera’s flip (hflip, vflip).'],
  hint_outside_roster: ['ids are outside the roster', 'Add them to roster in [[marker]], or leave it out.'],
};

const drops = {
  lost_before: 'The camera or its bus lost them: check the cable, USB port or packet size.',
  corrupt: 'They came damaged: check the cable, and for GigE the packet size.',
  wrong_size: 'They have another size than the calibration: set width and height in [capture].',
  superseded: 'The computer is too slow for this rate: fewer frames a second, fewer pixels, or more workers.',
  stopped: 'They waited when chequerd was stopped; nothing to do.',
};

/// [level, what, what to do] of a camera now. @param silent whether it is not heard.
export function cameraAdvice(status, silent, previous) {
  const list = [];
  if (silent) list.push(['bad', 'not heard any more', 'Is chequerd running? systemctl status chequerd@…; chequerd(8) tells of routes.']);
  if (!status) return list;
  if (status.camera_state !== 'running') list.push(['bad', `camera ${status.camera_state}`, status.camera_message || 'chequerd goes on trying.']);
  else if (status.camera_message) list.push(['warn', 'the camera has something to say', status.camera_message]);
  if (status.publisher_message) list.push(['warn', 'publishing', status.publisher_message]);
  for (const [name, count] of Object.entries(status.drops)) {
    const lost = previous ? count - (previous.drops[name] ?? 0) : 0;
    if (lost > 0 && name !== 'stopped') list.push(['warn', `${lost} frames lost in the last seconds: ${name}`, drops[name] ?? 'See status_t.']);
  }
  const detections = status.detections;
  const frames = Math.max(1, status.publish_rate_hz * (1));
  if ((detections.deferred ?? 0) > 0.5 * frames)
    list.push(['warn', `${detections.deferred} pieces of work deferred a second`, 'Frames cost more than their budget: fewer frames a second, more workers, or markers that move less.']);
  const markers = Math.max(1, status.markers_mean * frames);
  for (const [name, [what, todo, level = 'warn']] of Object.entries(warningAdvice)) {
    if (level === 'good') continue;
    const share = (detections[`warning_${name}`] ?? 0) / markers;
    if (share > 0.1) list.push(['warn', `${(100 * Math.min(1, share)).toFixed(0)} % of the markers: ${what}`, todo]);
  }
  for (const [name, [what, todo]] of Object.entries(hints)) if (detections[name] > 0) list.push(['warn', what, todo]);
  for (const name of Object.keys(detections))
    if (name.startsWith('hint_looks_like_')) list.push(['warn', `boards look like ${name.slice(16)}`, 'Compare variant in [[marker]] with the print.']);
  if (!list.length) list.push(['good', 'all is well', '']);
  return list;
}

/// Which knob to turn, by the cells of one marker and the means of all: [level, knob, which way, why].
export function setupAdvice(means, detail) {
  const list = [];
  const light = detail?.found ? detail.luminance_light.mean : NaN, dark = detail?.found ? detail.luminance_dark.mean : NaN;
  if (light > 97) list.push(['warn', 'exposure', 'shorter', `light cells are at ${light.toFixed(0)} of 100: they are cut off`]);
  else if (light < 45) list.push(['warn', 'exposure', 'longer', `light cells are at ${light.toFixed(0)} of 100`]);
  else if (means.luminance > 0.02) list.push(['warn', 'exposure', light > 80 ? 'shorter, or less glare' : 'longer, or more light', `dark and light overlap by ${(100 * means.luminance).toFixed(1)} %`]);
  else if (light === light || means.count) list.push(['good', 'exposure', 'leave it', light === light ? `light cells ${light.toFixed(0)}, dark ${dark.toFixed(0)} of 100` : 'dark and light stand apart']);
  const cast = detail?.found ? whiteCast(detail) : null;
  if (cast !== null && Math.abs(cast) > 8) list.push(['warn', 'white balance', cast > 0 ? 'more blue (lower colour temperature setting)' : 'more red (higher colour temperature setting)', `white cells are ${Math.abs(cast).toFixed(0)} too ${cast > 0 ? 'yellow' : 'blue'}`]);
  else if (means.saturation > 0.02) list.push(['warn', 'white balance', 'set it by hand on something white', `plain and saturated overlap by ${(100 * means.saturation).toFixed(1)} %`]);
  else if (means.count) list.push(['good', 'white balance', 'leave it', cast !== null ? `white cells off by ${cast.toFixed(0)}` : 'inks stand apart']);
  if (means.blurred) list.push(['warn', 'focus', 'turn it until the residual below is least', 'frames look blurred']);
  else if (means.rms > 0.3) list.push(['warn', 'focus', 'turn it until the residual below is least', `corners lie ${means.rms.toFixed(2)} px off`]);
  else if (means.count) list.push(['good', 'focus', 'leave it', `corners lie ${means.rms.toFixed(2)} px off`]);
  if (!means.count) list.push(['warn', 'markers', 'show one to the camera', 'none is seen now']);
  return list;
}

/// How yellow (above 0) or blue white cells are: the saturation of light plain cells is their b*.
function whiteCast(detail) {
  const whites = detail.cells.filter((cell, i) => cell.seen && cell.saturated === false && ((Math.floor(i / detail.cols) + i % detail.cols) % 2 === 1));
  return whites.length < 2 ? null : whites.reduce((sum, cell) => sum + cell.saturation, 0) / whites.length;
}
