// The cell in 3-D: builds what experiments/replay_scene.cpp describes and moves it.

import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { decodeShape } from './decode.js';

export const METRES_PER_NEWTON = 0.005;
const LONGEST_ARROW = 0.4; // m
const SMALLEST_FORCE = 0.2; // N
const ROBOT = /^(link\d|gripper|jaw_)/;
const COLOUR_ROBOT = 0xe02020; // contacts of the robot
const COLOUR_OTHER = 0x2f7ebc; // between objects and the cell

/** Geometry of a part, and the turn from three.js's axes (cylinders along y) to MuJoCo's (z). */
function geometryOf(part, shapes) {
  const [a, b, c] = part.size ?? [];
  switch (part.kind) {
    case 'box':
      return new THREE.BoxGeometry(2 * a, 2 * b, 2 * c);
    case 'sphere':
      return new THREE.SphereGeometry(a, 32, 16);
    case 'cylinder':
      return new THREE.CylinderGeometry(a, a, 2 * b, 40).rotateX(Math.PI / 2);
    case 'capsule':
      return new THREE.CapsuleGeometry(a, 2 * b, 8, 24).rotateX(Math.PI / 2);
    case 'plane':
      return new THREE.PlaneGeometry(2 * a, 2 * b);
    default:
      return shapes[part.shape];
  }
}

function meshGeometry(shape) {
  const { positions, triangles } = decodeShape(shape);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
  geometry.computeVertexNormals();
  return geometry;
}

function place(object, [x, y, z, qx, qy, qz, qw]) {
  object.position.set(x, y, z);
  object.quaternion.set(qx, qy, qz, qw);
}

const UP = new THREE.Vector3(0, 0, 1);
const SHAFT = new THREE.CylinderGeometry(0.003, 0.003, 1, 12).rotateX(Math.PI / 2).translate(0, 0, 0.5);
const HEAD = new THREE.ConeGeometry(0.009, 0.025, 16).rotateX(Math.PI / 2);

/** An arrow that is seen through everything, along its z axis. */
class Arrow extends THREE.Group {
  constructor(colour) {
    super();
    const material = new THREE.MeshBasicMaterial({
      color: colour, depthTest: false, transparent: true,
    });
    this.shaft = new THREE.Mesh(SHAFT, material);
    this.head = new THREE.Mesh(HEAD, material);
    this.shaft.renderOrder = this.head.renderOrder = 1;
    this.add(this.shaft, this.head);
    this.visible = false;
  }

  point(from, along, length) {
    this.position.copy(from);
    this.quaternion.setFromUnitVectors(UP, along);
    this.shaft.scale.z = length;
    this.head.position.z = length;
  }
}

export class Stage {
  /** @throws when the browser offers no WebGL */
  constructor(canvas) {
    this.renderer = new THREE.WebGLRenderer({
      canvas, antialias: true, preserveDrawingBuffer: true, // for printing
    });
    this.camera = new THREE.PerspectiveCamera(38, 16 / 9, 0.05, 30);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => this.render());
    this.showForces = true;
  }

  /** Builds a scene anew; poses come with `show`. */
  load(scene, replay) {
    this.scene?.traverse((object) => {
      if (![SHAFT, HEAD].includes(object.geometry)) object.geometry?.dispose();
      object.material?.dispose();
    });
    this.replay = replay;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0xdfe6ee);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8f96, 1.9));
    const sun = new THREE.DirectionalLight(0xffffff, 1.7);
    sun.position.set(0.9, -0.9, 2.2);
    this.scene.add(sun);
    this.addParts(scene);
    this.arrows = replay.contacts.map(({ first, second }) => {
      const ofRobot = ROBOT.test(first) || ROBOT.test(second);
      const arrow = new Arrow(ofRobot ? COLOUR_ROBOT : COLOUR_OTHER);
      this.scene.add(arrow);
      // The force on the robot, and that on an object where no robot takes part.
      return { arrow, sign: ROBOT.test(first) && !ROBOT.test(second) ? -1 : 1 };
    });
    this.camera.position.set(...scene.camera.position);
    this.controls.target.set(...scene.camera.look_at);
    this.controls.update();
  }

  addParts(scene) {
    const shapes = scene.shapes.map(meshGeometry);
    this.bodies = scene.bodies.map(() => new THREE.Group());
    for (const body of this.bodies) this.scene.add(body);
    for (const part of scene.parts) {
      const [red, green, blue, alpha] = part.colour;
      const material = new THREE.MeshStandardMaterial({
        roughness: 0.7, transparent: alpha < 1, opacity: alpha, depthWrite: alpha >= 1,
      });
      material.color.setRGB(red, green, blue, THREE.SRGBColorSpace);
      const mesh = new THREE.Mesh(geometryOf(part, shapes), material);
      place(mesh, part.pose);
      (part.body < 0 ? this.scene : this.bodies[part.body]).add(mesh);
    }
  }

  /** Shows a frame, which may lie between two. */
  show(frame) {
    this.bodies.forEach((body, i) => this.move(body, this.replay.bodies[i], frame));
    this.arrows.forEach((each, i) => this.aim(each, this.replay.contacts[i].track, frame));
    this.render();
  }

  move(body, track, frame) {
    const { key, next, share } = track.at(frame);
    const numbers = Array.from({ length: 7 }, (_, i) => {
      const from = track.number(key, i);
      return from + share * (track.number(next, i) - from);
    });
    const [x, y, z] = numbers.map((steps) => steps * this.replay.positionStep);
    body.visible = [3, 4, 5, 6].some((i) => numbers[i] !== 0); // else it is out of the cell
    place(body, [x, y, z, ...numbers.slice(3)]);
    body.quaternion.normalize();
  }

  aim({ arrow, sign }, track, frame) {
    const key = track.key(Math.floor(frame));
    const vector = (first) => new THREE.Vector3(
      track.number(key, first), track.number(key, first + 1), track.number(key, first + 2));
    const force = vector(3).multiplyScalar(sign * this.replay.forceStep);
    arrow.visible = this.showForces && force.length() > SMALLEST_FORCE;
    if (!arrow.visible) return;
    const length = Math.min(force.length() * METRES_PER_NEWTON, LONGEST_ARROW);
    const from = vector(0).multiplyScalar(this.replay.positionStep);
    arrow.point(from, force.normalize(), length);
  }

  resize(width, height) {
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.render();
  }

  render() {
    if (this.scene) this.renderer.render(this.scene, this.camera);
  }
}
