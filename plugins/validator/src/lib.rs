//! An independent judge of a run: it reads frames, the world and the task log, and shares no code with the manager or the engine.
