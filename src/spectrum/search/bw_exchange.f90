module bw_exchange
  !! The exchange of some lines of a model for others, and by how much the squares of its prediction errors fall.
  use bw_kinds, only: dp
  use bw_line, only: find_wave, has_trend, line_type
  use bw_model, only: add_lines, at_sensors, has_gaps, model_type, rows_of_stretches, subtract_missing, white_lines
  use bw_noise, only: mixed_amplitude, squares_at_end, whiten
  implicit none (type, external)
  private
  public :: exchange_lines

contains

  pure subroutine exchange_lines(model, old, new, with_trend, fall)
    !! Add some lines to the residual, and subtract others.
    type(model_type), intent(inout) :: model
    type(line_type), intent(in) :: old(:), new(:)
    logical, intent(in) :: with_trend            !! fit offset and slope of each stretch again
    real(dp), intent(out) :: fall                !! of −2 ln L at a fixed noise level
    type(line_type) :: lines(size(old) + size(new))
    logical :: drifts(size(lines)), gaps
    real(dp) :: before
    integer :: k
    lines = [old, new]
    do k = size(old) + 1, size(lines)
      lines(k)%amplitude = -lines(k)%amplitude
    end do
    drifts = [(size(lines(k)%courses) > 0, k=1, size(lines))]
    before = squares_at_ends(model)
    gaps = has_gaps(model)
    if (any(drifts) .or. gaps .or. with_trend) before = before + sum(model%white**2)
    call add_to_ends(model, lines)
    if (any(drifts)) call add_drifting_lines(model, pack(lines, drifts))
    call add_lines(rows_of_stretches(model), white_lines(model, pack(lines, .not. drifts)), 1.0_dp, model%white, model%place, fall)
    if (with_trend) call subtract_white_trend(model)
    if (gaps) call subtract_missing(model)
    if (any(drifts) .or. gaps .or. with_trend) fall = -sum(model%white**2)
    fall = fall + before - squares_at_ends(model)
  end subroutine exchange_lines

  pure subroutine subtract_white_trend(model)
    !! Subtract offset and slope of the prediction errors of each stretch, and the residual's that cause them from its last samples.
    type(model_type), intent(inout) :: model
    real(dp) :: u(size(model%white, 1)), middle, slope, mean, gain(2)
    integer :: rows(2, 0:ubound(model%stretches, 2)), longest, b, s, i
    rows = rows_of_stretches(model)
    longest = maxval(rows(2, :) - rows(1, :)) + 1
    do b = 0, ubound(rows, 2)
      associate (first => rows(1, b), last => rows(2, b), n => rows(2, b) - rows(1, b) + 1)
        if (n < 1 .or. .not. has_trend(model%lines, longest, n)) cycle
        u(first:last) = [(real(i, dp), i=0, n - 1)]
        if (allocated(model%place)) u(first:last) = model%place(first:last) - model%place(first)
        middle = sum(u(first:last))/n
        u(first:last) = u(first:last) - middle
        do s = 1, size(model%white, 2)
          associate (x => model%white(first:last, s), h => model%noise%filter(:model%noise%order(s), s))
            mean = sum(x)/n
            slope = dot_product(u(first:last), x)/max(1.0_dp, sum(u(first:last)**2))
            x = x - mean - slope*u(first:last)
            gain = [sum(h), dot_product(h, [(real(i, dp), i=0, size(h) - 1)])]   ! of an offset, and of a slope
            slope = slope/gain(1)
            mean = (mean - slope*gain(2))/gain(1) - slope*middle
            associate (values => model%last_values(max(1, model%noise%lost - (model%stretches(2, b) - first)):, s, b))
              values = values - mean - slope*[(real(i, dp), i=model%stretches(2, b) - first + 1 - size(values), &
                & model%stretches(2, b) - first)]
            end associate
          end associate
        end do
      end associate
    end do
    call clear_ends(model)
  end subroutine subtract_white_trend

  pure subroutine add_drifting_lines(model, lines)
    !! Add the prediction errors of lines whose factor H changes along the record, to white samples.
    type(model_type), intent(inout) :: model
    type(line_type), intent(in) :: lines(:)
    type(line_type) :: mixed(size(lines))
    real(dp) :: motion(size(model%white, 1), 1)
    integer :: k, c, b
    mixed = lines
    do k = 1, size(lines)
      mixed(k)%amplitude = mixed_amplitude(model%noise, lines(k)%amplitude)
    end do
    do c = 1, size(model%white, 2)
      motion = 0
      call add_lines(model%stretches, at_sensors(mixed, [c]), 1.0_dp, motion, model%place)
      do b = 1, ubound(model%stretches, 2)
        associate (first => model%stretches(1, b), last => model%stretches(2, b))
          if (last < first) cycle
          call whiten(model%noise%filter(:model%noise%order(c), c), motion(first:last, 1))
          motion(max(first, last - model%noise%lost + 1):last, 1) = 0
          model%white(first:last, c) = model%white(first:last, c) + motion(first:last, 1)
        end associate
      end do
    end do
  end subroutine add_drifting_lines

  pure real(dp) function squares_at_ends(model) result(squares)
    !! The sum of squared prediction errors of all samples without a row.
    type(model_type), intent(in) :: model
    integer :: b
    squares = 0
    do b = 0, ubound(model%stretches, 2)
      associate (n => model%stretches(2, b) - model%stretches(1, b) + 1, lost => model%noise%lost)
        squares = squares + squares_at_end(model%noise, model%last_values(max(1, lost - n + 1):, :, b))
      end associate
    end do
  end function squares_at_ends

  pure subroutine add_to_ends(model, lines)
    !! Add lines to the residual of the last samples of each stretch.
    type(model_type), intent(inout) :: model
    type(line_type), intent(in) :: lines(:)
    complex(dp) :: wave(model%noise%lost)
    integer :: k, c, b, first
    if (model%noise%lost == 0) return
    do k = 1, size(lines)
      associate (amplitude => mixed_amplitude(model%noise, lines(k)%amplitude))
        do b = merge(0, 1, lines(k)%steady), ubound(model%stretches, 2)
          first = max(1, model%noise%lost - (model%stretches(2, b) - model%stretches(1, b)))
          call find_wave(lines(k), real(model%stretches(2, b) - model%stretches(1, b) + first - model%noise%lost, dp), &
            & wave=wave(first:))
          do c = 1, size(amplitude, 1)
            model%last_values(first:, c, b) = model%last_values(first:, c, b) + real(amplitude(c, b + 1)*wave(first:), dp)
          end do
        end do
      end associate
    end do
    call clear_ends(model)
  end subroutine add_to_ends

  pure subroutine clear_ends(model)
    !! Set missing samples to 0 there.
    type(model_type), intent(inout) :: model
    integer :: b, c
    do c = 1, size(model%missing)
      do b = 0, ubound(model%stretches, 2)
        associate (n => model%missing(c)%place - model%stretches(2, b) + model%noise%lost)
          model%last_values(pack(n, n > 0 .and. n <= model%noise%lost), c, b) = 0
        end associate
      end do
    end do
  end subroutine clear_ends

end module bw_exchange
