// Shows what a part of a plot tells while a pointer is over it, or a finger on it. Without this the same stands in the tables.
(() => {
  const tip = document.createElement('div');
  tip.className = 'tip';
  tip.hidden = true;
  document.body.append(tip);
  const hide = () => { tip.hidden = true; };
  const show = event => {
    const mark = event.target.closest?.('.mark');
    if (!mark) return hide();
    tip.textContent = mark.dataset.told;
    tip.hidden = false;
    const wide = document.documentElement.clientWidth;
    const left = Math.min(Math.max(8, event.clientX + 14), Math.max(8, wide - tip.offsetWidth - 8));
    const above = event.clientY - tip.offsetHeight - 12;
    tip.style.left = left + 'px';
    tip.style.top = (above > 4 ? above : event.clientY + 18) + 'px';
  };
  for (const kind of ['pointermove', 'pointerdown']) addEventListener(kind, show, { passive: true });
  for (const kind of ['scroll', 'blur']) addEventListener(kind, hide, { passive: true });
  addEventListener('keydown', event => { if (event.key === 'Escape') hide(); });
  document.documentElement.dataset.hover = 'ready';
})();
