// The page of hv-live: shows what the server says, and says what the visitor wants.

import { Link } from "/page/link.js";
import { Orbit } from "/page/orbit.js";
import { RoomMap } from "/page/room_map.js";

const $ = (id) => document.getElementById(id);
const NOTICE_MS = 9000;
const MARKS = { now: "▸", done: "✓", left: "–" };
const BY = { task: "task", you: "you", instructor: "instructor" };

let hello = null, state = null, steers = false, noticeTimer = 0, pictures = 0, drawing = 0;

const link = new Link({
  open: () => cover(""),
  lost: () => { cover("Connection lost. Trying again …"); setSteers(false); },
  message: (message) => HANDLERS[message.type]?.(message),
  pictures: drawPictures,
});
const map = new RoomMap($("map"), (label) => {
  const text = $("text");
  text.value = text.value.trim() ? `${text.value.trimEnd()} ${label} ` : `Put ${label} `;
  text.focus();
});
const orbit = new Orbit($("third-person"), (fields) => link.send("camera", fields));

const HANDLERS = {
  hello(message) {
    hello = message;
    const kinds = [...new Set(message.tasks.map((task) => task.room))];
    options($("kind"), [["", "any"], ...kinds.map((kind) => [kind, kind.replace("_", " ")])]);
    fillTasks();
    $("policies").replaceChildren(...message.policies.map((name) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = button.title = name;
      button.dataset.name = name;
      if (message.missing.includes(name)) {
        button.dataset.missing = "";
        button.title = `the ${name}'s weights do not come with this package yet`;
      }
      button.addEventListener("click", () => link.send("policy", { name }));
      return button;
    }));
    setSteers(steers);
  },

  role(message) {
    setSteers(message.steers);
    $("role").hidden = message.visitors < 2 && message.steers;
    const others = message.visitors - 1;
    $("role").textContent = message.steers ? `${others} watching` : "watching: another visitor steers";
  },

  room(message) {
    map.draw(message);
    $("room-title").textContent = message.title;
    $("suggestions").replaceChildren(...message.suggestions.map((text) => {
      const chip = document.createElement("button");
      chip.type = "button";
      chip.textContent = chip.title = text;
      chip.disabled = !steers;
      chip.addEventListener("click", () => tell(text));
      return chip;
    }));
    fillTasks(message.task);
    cover("");
  },

  state(message) {
    state = message;
    map.show(message);
    orbit.follow(message.camera);
    setText("instruction", message.instruction);
    setText("stage", stageText(message));
    const bar = $("progress");
    if (message.progress === null) bar.removeAttribute("value");
    else bar.value = message.progress;
    press("pause", message.paused, message.paused ? "Go on" : "Pause");
    press("record", message.recording !== null, message.recording === null ? "Record" : "Stop");
    $("recording").hidden = message.recording === null;
    if (message.recording !== null) setText("recording", `${(message.recording / 30).toFixed(0)} s recorded`);
    $("instructor").checked = message.instructor;
    for (const button of $("policies").children) {
      button.setAttribute("aria-pressed", String(button.dataset.name === message.policy));
    }
    $("slow").hidden = !message.slow;
    setText("slow", "slower than real time");
    setText("speed", message.paused ? "paused" : `${message.speed.toFixed(2)}× · ${message.pictures_per_s.toFixed(0)} pictures/s`);
    setText("clock", `${message.time_s.toFixed(1)} s · step ${message.step} · ${message.step_ms.toFixed(0)} ms a step`);
    $("camera-home").hidden = message.camera.home || !steers;
    showSaid(message.said);
    document.body.classList.toggle("fallen", message.fallen);
  },

  notice: (message) => notice(message.text, false),
  error(message) { cover(""); notice(message.text, true); },
};

function stageText(message) {
  const fallen = message.fallen ? "it fell; " : "";
  const away = message.distance_m === null || message.stage === "done" ? "" : `, ${message.distance_m.toFixed(1)} m to go`;
  return `${message.policy}: ${fallen}${message.stage}${away}`;
}

function showSaid(said) {
  const key = said.map((s) => s.status + s.text + (s.status === "now" ? "" : s.seconds)).join("|");
  if (showSaid.key === key) return;
  showSaid.key = key;
  $("said").replaceChildren(...[...said].reverse().map((s) => {
    const line = document.createElement("li");
    line.className = s.status;
    const time = s.status === "done" ? ` · ${s.seconds.toFixed(0)} s` : "";
    for (const [name, text] of [["mark", MARKS[s.status]], ["text", s.text], ["by", BY[s.by] + time]]) {
      const part = document.createElement("span");
      part.className = name;
      part.textContent = text;
      line.append(part);
    }
    return line;
  }));
}

async function drawPictures(thirdPerson, head) {
  if (drawing) return; // this browser is slower than the server; the next ones will do
  drawing = 1;
  try {
    const bitmaps = await Promise.all([createImageBitmap(thirdPerson), createImageBitmap(head)]);
    ["third-person", "head"].forEach((id, i) => {
      const canvas = $(id), bitmap = bitmaps[i];
      if (canvas.width !== bitmap.width) canvas.width = bitmap.width;
      if (canvas.height !== bitmap.height) canvas.height = bitmap.height;
      canvas.getContext("2d").drawImage(bitmap, 0, 0);
      bitmap.close();
    });
    document.body.dataset.pictures = String(++pictures);
  } finally {
    drawing = 0;
  }
}

function fillTasks(chosen = $("task").value) {
  if (!hello) return;
  const kind = $("kind").value;
  const shown = hello.tasks.filter((task) => !kind || task.room === kind || task.name === chosen);
  options($("task"), shown.map((task) => [task.name, kind ? task.name : task.name.startsWith(task.room) ? task.name : `${task.name} · ${task.room.replace("_", " ")}`]));
  $("task").value = chosen;
}

function options(select, pairs) {
  select.replaceChildren(...pairs.map(([value, text]) => new Option(text, value)));
}

function setSteers(may) {
  steers = may;
  orbit.enabled = may;
  for (const element of document.querySelectorAll("main button, main input, main select")) {
    element.disabled = !may || "missing" in element.dataset;
  }
}

function tell(text) {
  if (link.send("instruct", { text })) notice("", false);
}

function press(id, on, label) {
  $(id).setAttribute("aria-pressed", String(on));
  $(id).firstElementChild.textContent = label;
}

function setText(id, text) {
  if ($(id).textContent !== text) $(id).textContent = text;
}

function cover(text) {
  $("cover").hidden = !text;
  setText("cover", text);
}

function notice(text, isError) {
  clearTimeout(noticeTimer);
  $("notice").hidden = !text;
  $("notice").classList.toggle("error", isError);
  setText("notice", text.charAt(0).toUpperCase() + text.slice(1));
  if (text) noticeTimer = setTimeout(() => { $("notice").hidden = true; }, NOTICE_MS);
}

const push = () => link.send("push", { direction_deg: Math.round(Math.random() * 360 - 180), speed_m_s: 0.6 });
const pause = () => link.send("pause", { on: !state?.paused });

$("talk").addEventListener("submit", (event) => {
  event.preventDefault();
  const text = $("text").value.trim();
  if (!text) return;
  tell(text);
  $("text").value = "";
});
$("pause").addEventListener("click", pause);
$("reset").addEventListener("click", () => link.send("reset"));
$("push").addEventListener("click", push);
$("record").addEventListener("click", () => link.send("record", { on: state?.recording === null }));
$("instructor").addEventListener("change", (event) => link.send("instructor", { on: event.target.checked }));
$("camera-home").addEventListener("click", () => { orbit.forget(); link.send("camera_home"); });
$("kind").addEventListener("change", () => fillTasks());
$("task").addEventListener("change", (event) => { cover("Building the room …"); link.send("load", { task: event.target.value }); });

document.addEventListener("keydown", (event) => {
  const typing = /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName);
  if (event.key === "Escape" && typing) event.target.blur();
  if (typing || event.ctrlKey || event.metaKey || event.altKey || event.repeat || !steers) return;
  const onButton = event.target.tagName === "BUTTON";
  if (event.key === "/") $("text").focus();
  else if (event.key === " " && !onButton) pause();
  else if (event.key.toLowerCase() === "r") link.send("reset");
  else if (event.key.toLowerCase() === "p") push();
  else return;
  event.preventDefault();
});
