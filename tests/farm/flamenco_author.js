// SPDX-License-Identifier: GPL-3.0-or-later
//
// What Flamenco Manager gives a job compiler script, strictly: what the Manager does not have, and what it takes in
// silence but a worker would choke on, throws here. The host functions are Python's: see flamenco_manager.py.
"use strict";

const authored = { tasks: [], dependencies: [] };

function strictly(what, members, writable) {
    return new Proxy(members, {
        get(target, key) {
            if (!(key in target)) {
                throw new TypeError(`${what} has no member "${String(key)}"`);
            }
            return target[key];
        },
        set(target, key, value) {
            if (!writable || !(key in target)) {
                throw new TypeError(`${what}: "${String(key)}" cannot be set`);
            }
            target[key] = value;
            return true;
        },
    });
}

function takes(what, given, ...types) {
    const names = Array.from(given, (value) => typeof value);
    if (names.length !== types.length || names.some((name, i) => name !== types[i])) {
        throw new TypeError(`${what} takes (${types}), not (${names})`);
    }
}

function plain(what, value) {
    if (typeof value === "string" || typeof value === "boolean" || Number.isFinite(value)) {
        return value;
    }
    if (Array.isArray(value)) {
        return value.map((item) => plain(what, item));
    }
    throw new TypeError(`${what}: ${String(value)} is no string, number or list of them`);
}

const author = strictly("author", {
    Task(name, type) {
        takes("author.Task", arguments, "string", "string");
        if (!name.trim() || !type.trim()) {
            throw new TypeError("author.Task(name, type): both are required");
        }
        const made = { name: name.trim(), type: type.trim(), commands: [], dependencies: [] };
        const task = strictly("a task", {
            name: made.name,
            type: made.type,
            addCommand(command) {
                if (arguments.length !== 1 || !(command instanceof AuthoredCommand)) {
                    throw new TypeError("addCommand takes what author.Command gives");
                }
                made.commands.push(command);
            },
            addDependency(other) {
                if (arguments.length !== 1 || !handles.has(other)) {
                    throw new TypeError("addDependency takes what author.Task gives");
                }
                made.dependencies.push(handles.get(other));
            },
        });
        handles.set(task, made);
        return task;
    },
    Command(name, parameters, totalStepCount) {
        if (arguments.length === 3) {
            takes("author.Command", arguments, "string", "object", "number");
        } else {
            takes("author.Command", arguments, "string", "object");
        }
        return new AuthoredCommand(name, parameters, totalStepCount || 0);
    },
});

const handles = new Map();

class AuthoredCommand {
    constructor(name, parameters, steps) {
        this.name = name;
        this.parameters = {};
        for (const key of Object.keys(parameters)) {
            this.parameters[key] = plain(`${name}'s parameter ${key}`, parameters[key]);
        }
        this.totalStepCount = steps;
    }
}

const path = strictly("path", {
    basename: (whole) => slashed(whole).replace(/\/+$/, "").split("/").pop(),
    dirname: (whole) => slashed(whole).split("/").slice(0, -1).join("/") || ".",
    join: (...parts) => parts.map(slashed).filter((part) => part).join("/").replace(/\/+/g, "/"),
    stem: (whole) => path.basename(whole).replace(/\.[^.]*$/, ""),
});

function slashed(whole) {
    takes("path", [whole], "string");
    return whole.replace(/\\/g, "/");
}

function print() {}

function frameChunker(frames, size) {
    takes("frameChunker", arguments, "string", "number");
    return answered(hostFrameChunker(frames, size));
}

function frameCount(frames) {
    takes("frameCount", arguments, "string");
    return answered(hostFrameCount(frames));
}

function shellSplit(words) {
    takes("shellSplit", arguments, "string");
    return answered(hostShellSplit(words));
}

function formatTimestampLocal(time) {
    if (time !== CREATED) {
        throw new TypeError("formatTimestampLocal takes a time such as job.created");
    }
    return "2026-01-31_235959";
}

const CREATED = strictly("a time", {});

function answered(json) {
    const answer = JSON.parse(json);
    if (answer.error) {
        throw new Error(answer.error);
    }
    return answer.value;
}

// Compiles a job as the Manager does; the keys name the declared settings, of which some may have no value.
function compiled(keys, values) {
    const settings = {};
    for (const key of keys) {
        settings[key] = values[key];
    }
    const job = strictly("the job", {
        name: "A job",
        created: CREATED,
        settings: strictly("job.settings", settings, true),
        addTask(task) {
            if (arguments.length !== 1 || !handles.has(task)) {
                throw new TypeError("addTask takes what author.Task gives");
            }
            // The Manager copies the task here: what is added to it later is lost.
            const made = handles.get(task);
            authored.tasks.push({ made, commands: made.commands.slice(), dependencies: made.dependencies.slice() });
        },
    });
    compileJob(job);
    const order = authored.tasks.map((task) => task.made);
    return {
        settings,
        tasks: authored.tasks.map((task) => ({
            name: task.made.name,
            type: task.made.type,
            commands: task.commands,
            dependencies: task.dependencies.map((made) => order.indexOf(made)),
        })),
    };
}
